"""Accelerometers on I2C, serial ports and in the Linux kernel (IIO), behind one interface.

Not here: the bus itself (drivers/buses). Begin with accelerometer.py; a new part is one table in
register_tables/ or serial_devices.py.
"""

__all__ = [
    "accelerometer",
    "accelerometer_factory",
    "i2c_accelerometer",
    "mounting",
    "register_tables",
    "serial_decoders",
    "serial_devices",
]
