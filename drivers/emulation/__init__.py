"""The rig's end of emulated parts: what feels an acceleration or takes a command, and answers in the part's
own language.

Not here: register files of I2C chips (drivers/emulated_chips). Begin with emulated_accelerometer.py.
"""

__all__ = ["cia402_node", "emulated_accelerometer", "odrive_motor", "pty_port"]
