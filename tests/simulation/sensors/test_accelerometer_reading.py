"""Virtual time's short cut gives what driver, smbus2 and emulator give together."""

import secrets
from math import isnan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.drivers.accelerometers.accelerometer_factory import open_accelerometer
from stillarm.drivers.accelerometers.mounting import sensed_axes
from stillarm.drivers.accelerometers.register_tables import TABLES
from stillarm.drivers.emulation.emulated_accelerometer import emulate_accelerometer
from stillarm.simulation.sensors.accelerometer_reading import accelerometer_reading

SETTINGS = [
    *((part, axis, full_scale_g) for part in ("lis3lv02dq",) for axis in "xyz" for full_scale_g in (2, 6)),
    *((part, "y", max(TABLES[part].full_scales)) for part in TABLES),
]


def compare(device: AccelerometerDevice, accelerations: list[float], tolerance_m_s2: float = 0.0) -> None:
    """That both give the same, cycle by cycle."""
    emulated = emulate_accelerometer(device, 0.001)
    driver = open_accelerometer(device, wait_s=0.0)
    assert driver is not None
    driver.start()
    read = accelerometer_reading(device)
    try:
        for acceleration in accelerations:
            emulated.publish(sensed_axes(acceleration, device))
            through, short = driver.read(), read(acceleration)
            assert abs(through - short) <= tolerance_m_s2 or (isnan(through) and isnan(short))
    finally:
        driver.close()
        emulated.close()


@pytest.mark.slow
@pytest.mark.parametrize(("part", "axis", "full_scale_g"), SETTINGS)
@given(accelerations=st.lists(st.floats(-100.0, 100.0), min_size=1, max_size=20))
@settings(max_examples=15, deadline=None)
def test_the_same_numbers_as_through_the_bus(
    part: str, axis: str, full_scale_g: int, accelerations: list[float]
) -> None:
    """For any acceleration, clipped ones included; to rounding, and to the bit for the default part."""
    bus = f"memory:test-reading-{secrets.token_hex(4)}"
    device = AccelerometerDevice(driver=part, bus=bus, axis=axis, full_scale_g=full_scale_g)  # type: ignore[arg-type]
    compare(device, accelerations, 0.0 if part == "lis3lv02dq" else 1e-12)


@given(accelerations=st.lists(st.floats(-15.0, 15.0), min_size=1, max_size=20))
@settings(max_examples=15, deadline=None)
def test_the_same_numbers_for_a_sensor_mounted_askew(accelerations: list[float]) -> None:
    """Rotated, reversed and biased."""
    device = AccelerometerDevice(
        bus=f"memory:test-reading-{secrets.token_hex(4)}",
        rotation_deg=(10.0, 20.0, -30.0),
        sign=-1,
        bias_m_s2=0.5,
    )
    compare(device, accelerations, 1e-9)


def test_no_accelerometer_reads_nothing() -> None:
    """driver = "none"."""
    assert accelerometer_reading(AccelerometerDevice(driver="none"))(1.0) != 1.0
