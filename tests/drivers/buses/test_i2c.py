"""Opening buses, emulated and real, by their names."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.accelerometers.i2c_accelerometer import I2cAccelerometer
from stillarm.drivers.accelerometers.register_tables import TABLES
from stillarm.drivers.buses.i2c import open_bus
from stillarm.drivers.emulated_chips.lis3lv02dq_registers import LIS3LV02DQ_PART
from stillarm.drivers.emulated_chips.shared_registers import SensedRegisters
from stillarm.drivers.standard_gravity import STANDARD_GRAVITY_M_S2

NAME = f"test-bus-{os.getpid()}"
BUS = f"memory:{NAME}"
ADDRESS = 0x1D
COUNT_M_S2 = STANDARD_GRAVITY_M_S2 / 1024.0


@pytest.fixture
def registers() -> Iterator[SensedRegisters]:
    made = SensedRegisters(NAME, LIS3LV02DQ_PART)
    yield made
    made.close()


def opened(config: AccelerometerDevice) -> I2cAccelerometer:
    return I2cAccelerometer(config, TABLES["lis3lv02dq"], wait_s=0.0)


def test_a_missing_bus_is_told_with_its_remedy(tmp_path: Path) -> None:
    missing = opened(AccelerometerDevice(bus=str(tmp_path / "i2c-9")))
    with pytest.raises(UserError, match=r"^accelerometer\.bus = [^\n]*modprobe i2c-dev[^\n]*$"):
        missing.start()
    with pytest.raises(UserError, match=r"^accelerometer\.bus = 'memory:nobody-made-it': [^\n]*rig[^\n]*$"):
        opened(AccelerometerDevice(bus="memory:nobody-made-it")).start()


def test_the_emulated_bus_leaves_real_ones_to_the_kernel(registers: SensedRegisters, tmp_path: Path) -> None:
    open_bus(BUS).close()
    file = tmp_path / "no-bus"
    file.touch()
    with pytest.raises(UserError, match=r"^accelerometer\.bus = [^\n]*cannot be opened as an I2C bus[^\n]*$"):
        open_bus(str(file))
    with pytest.raises(UserError, match="no such bus"):
        open_bus(str(tmp_path / "absent"))


def test_a_bus_that_one_may_not_open(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> int:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("smbus2.smbus2.os.open", refuse)
    with pytest.raises(
        UserError, match=r"^accelerometer\.bus = '/dev/i2c-1': permission denied; [^\n]*group[^\n]*$"
    ):
        open_bus("/dev/i2c-1")
