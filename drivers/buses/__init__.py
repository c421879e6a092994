"""I2C buses and serial ports, opened by their name in the configuration; "memory:NAME" is an emulated bus.

Not here: devices. Begin with i2c.py and serial_port.py.
"""

__all__ = ["i2c", "parts", "serial_port"]
