"""The I2C accelerometers, one table each, by the name that the configuration gives them.

Not here: code that reads a table (i2c_accelerometer.py beside this package). Begin with register_table.py.
"""

from stillarm.drivers.accelerometers.register_tables.adxl345 import ADXL345
from stillarm.drivers.accelerometers.register_tables.adxl355 import ADXL355
from stillarm.drivers.accelerometers.register_tables.icm20948 import ICM20948
from stillarm.drivers.accelerometers.register_tables.lis3dh import LIS3DH
from stillarm.drivers.accelerometers.register_tables.lis3lv02dq import LIS3LV02DQ
from stillarm.drivers.accelerometers.register_tables.mpu6050 import MPU6050
from stillarm.drivers.accelerometers.register_tables.register_table import RegisterTable

TABLES: dict[str, RegisterTable] = {
    "lis3lv02dq": LIS3LV02DQ,
    "lis3dh": LIS3DH,
    "adxl345": ADXL345,
    "adxl355": ADXL355,
    "mpu6050": MPU6050,
    "icm20948": ICM20948,
}

__all__ = ["TABLES", "register_table"]
