"""Axis, sign and rotation: what a sensor feels and what is read from it belong together."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.drivers.accelerometers.mounting import measured_direction, sensed_axes
from stillarm.drivers.standard_gravity import STANDARD_GRAVITY_M_S2

ANGLES = st.tuples(*[st.floats(-360.0, 360.0)] * 3)
MOUNTS = st.builds(
    AccelerometerDevice, axis=st.sampled_from("xyz"), sign=st.sampled_from([1, -1]), rotation_deg=ANGLES
)


def dot(one: Any, other: Any) -> float:
    return float(sum(a * b for a, b in zip(one, other, strict=True)))


@pytest.mark.slow
@given(MOUNTS, st.floats(-50.0, 50.0))
def test_what_is_felt_is_what_is_read(mount: AccelerometerDevice, acceleration: float) -> None:
    """For any mounting, gravity is perpendicular to the measured axis."""
    felt = sensed_axes(acceleration, mount)
    assert dot(measured_direction(mount), felt) == pytest.approx(acceleration, abs=1e-9)
    assert dot(felt, felt) == pytest.approx(acceleration**2 + STANDARD_GRAVITY_M_S2**2)


@given(MOUNTS)
def test_the_direction_is_a_unit_vector(mount: AccelerometerDevice) -> None:
    direction = measured_direction(mount)
    assert dot(direction, direction) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("axis", "rotation_deg", "sensed"),
    [
        ("y", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        ("y", (0.0, 0.0, 90.0), (1.0, 0.0, 0.0)),  # turned about z: the sensor's x lies along the arm's y
        ("z", (0.0, -90.0, 0.0), (1.0, 0.0, 0.0)),  # about y: its x along the arm's z
        ("y", (-90.0, 0.0, 0.0), (0.0, 0.0, 1.0)),  # about x: its z along the arm's y
    ],
)
def test_quarter_turns(axis: Any, rotation_deg: Any, sensed: tuple[float, float, float]) -> None:
    direction = measured_direction(AccelerometerDevice(axis=axis, rotation_deg=rotation_deg))
    assert direction == pytest.approx(sensed, abs=1e-12)
