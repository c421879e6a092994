"""Emulated I2C chips, bytes in and bytes out, with registers in memory that the simulated rig and the
driver's process share.

Not here: emulated serial devices and drives (drivers/emulation). Begin with register_chip.py.
"""

__all__ = [
    "adxl345_chip",
    "adxl355_chip",
    "icm20948_chip",
    "lis3dh_chip",
    "lis3lv02dq_chip",
    "lis3lv02dq_registers",
    "mcp4725_chip",
    "mpu6050_chip",
    "register_chip",
    "shared_registers",
]
