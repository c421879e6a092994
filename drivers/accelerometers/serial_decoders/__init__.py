"""Frames of serial accelerometers: pure, incremental decoders.

Not here: ports (drivers/buses) and the table of devices (serial_devices.py). Begin with framing.py.
"""

__all__ = ["framing", "microcontroller", "vectornav", "witmotion", "xsens"]
