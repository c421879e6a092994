"""Virtual time's short cut gives what driver, smbus2 and emulator give together."""

import secrets

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.configuration import AccelerometerDevice
from drivers.accelerometer_factory import open_accelerometer
from drivers.emulation.lis3lv02dq_registers import Lis3lv02dqRegisters, sensed_axes
from simulation.accelerometer_reading import accelerometer_reading


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("full_scale_g", [2, 6])
@given(accelerations=st.lists(st.floats(-100.0, 100.0), min_size=1, max_size=20))
@settings(max_examples=15, deadline=None)
def test_the_same_numbers_as_through_the_bus(
    axis: str, full_scale_g: int, accelerations: list[float]
) -> None:
    """For any acceleration, clipped ones included; to the bit."""
    name = f"test-reading-{secrets.token_hex(4)}"
    registers = Lis3lv02dqRegisters(name)
    device = AccelerometerDevice(bus=f"memory:{name}", axis=axis, full_scale_g=full_scale_g)  # type: ignore[arg-type]
    driver = open_accelerometer(device, wait_s=0.0)
    assert driver is not None
    driver.start()
    read = accelerometer_reading(device)
    try:
        for acceleration in accelerations:
            registers.publish(sensed_axes(acceleration, axis))  # type: ignore[arg-type]
            assert driver.read() == read(acceleration)
    finally:
        driver.close()
        registers.close()


def test_no_accelerometer_reads_nothing() -> None:
    """driver = "none"."""
    assert accelerometer_reading(AccelerometerDevice(driver="none"))(1.0) != 1.0
