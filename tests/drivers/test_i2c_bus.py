"""Opening buses, emulated and real, by their names."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from common.configuration import AccelerometerDevice
from common.user_error import UserError
from drivers.emulation.lis3lv02dq_registers import (
    STANDARD_GRAVITY_M_S2,
    Lis3lv02dqRegisters,
)
from drivers.i2c import open_bus
from drivers.lis3lv02dq import Lis3lv02dq

NAME = f"test-bus-{os.getpid()}"
BUS = f"memory:{NAME}"
ADDRESS = 0x1D
COUNT_M_S2 = STANDARD_GRAVITY_M_S2 / 1024.0


@pytest.fixture
def registers() -> Iterator[Lis3lv02dqRegisters]:
    made = Lis3lv02dqRegisters(NAME)
    yield made
    made.close()


def test_a_missing_bus_is_told_with_its_remedy(tmp_path: Path) -> None:
    missing = Lis3lv02dq(AccelerometerDevice(bus=str(tmp_path / "i2c-9")), wait_s=0.0)
    with pytest.raises(UserError, match=r"^accelerometer\.bus = [^\n]*modprobe i2c-dev[^\n]*$"):
        missing.start()
    with pytest.raises(UserError, match=r"^accelerometer\.bus = 'memory:nobody-made-it': [^\n]*rig[^\n]*$"):
        Lis3lv02dq(AccelerometerDevice(bus="memory:nobody-made-it"), wait_s=0.0).start()


def test_the_emulated_bus_leaves_real_ones_to_the_kernel(
    registers: Lis3lv02dqRegisters, tmp_path: Path
) -> None:
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
