"""The I2C accelerometers by their names in the configuration. Each file is one register table."""

from drivers.accelerometer_tables.adxl345 import ADXL345
from drivers.accelerometer_tables.adxl355 import ADXL355
from drivers.accelerometer_tables.icm20948 import ICM20948
from drivers.accelerometer_tables.lis3dh import LIS3DH
from drivers.accelerometer_tables.lis3lv02dq import LIS3LV02DQ
from drivers.accelerometer_tables.mpu6050 import MPU6050
from drivers.accelerometer_tables.register_table import RegisterTable

TABLES: dict[str, RegisterTable] = {
    "lis3lv02dq": LIS3LV02DQ,
    "lis3dh": LIS3DH,
    "adxl345": ADXL345,
    "adxl355": ADXL355,
    "mpu6050": MPU6050,
    "icm20948": ICM20948,
}
