"""The emulated I2C accelerometers by their names in the configuration, and by number."""

from stillarm.drivers.buses.i2c_adapter import I2cAdapter
from stillarm.drivers.emulated_chips.adxl345_chip import ADXL345_CHIP
from stillarm.drivers.emulated_chips.adxl355_chip import ADXL355_CHIP
from stillarm.drivers.emulated_chips.icm20948_chip import ICM20948_CHIP
from stillarm.drivers.emulated_chips.lis3dh_chip import LIS3DH_CHIP
from stillarm.drivers.emulated_chips.lis3lv02dq_chip import Lis3lv02dqChip
from stillarm.drivers.emulated_chips.lis3lv02dq_registers import LIS3LV02DQ_PART
from stillarm.drivers.emulated_chips.mcp4725_chip import MCP4725_ADDRESS, MCP4725_PART, Mcp4725Chip
from stillarm.drivers.emulated_chips.mpu6050_chip import MPU6050_CHIP
from stillarm.drivers.emulated_chips.register_chip import RegisterChip
from stillarm.drivers.emulated_chips.shared_registers import SensedPart, SharedRegisters

_LIS3LV02DQ_ADDRESS = 0x1D
_LAYOUTS = (LIS3DH_CHIP, ADXL345_CHIP, ADXL355_CHIP, MPU6050_CHIP, ICM20948_CHIP)

SENSED_PARTS: dict[str, SensedPart] = {
    part.name: part for part in (LIS3LV02DQ_PART, *(layout.sensed for layout in _LAYOUTS))
}


def open_part(name: str, wait_s: float) -> I2cAdapter:
    """A bus with the part whose registers `name` a rig made. Raises UserError if there are none."""
    registers = SharedRegisters(name, wait_s)
    number = registers.part_number
    registers.close()
    if number == MCP4725_PART:
        return I2cAdapter(MCP4725_ADDRESS, Mcp4725Chip(name))
    for layout in _LAYOUTS:
        if layout.sensed.number == number:
            return I2cAdapter(layout.address, RegisterChip(layout, name))
    return I2cAdapter(_LIS3LV02DQ_ADDRESS, Lis3lv02dqChip(name))
