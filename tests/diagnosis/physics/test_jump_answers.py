"""A derivative by an impact's jump is that of another impact, moved in time: the same as by differences."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from numpy.typing import NDArray

from stillarm.common.files.model import Mode
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, empty

Array = NDArray[np.float64]

SECONDS = 3.0
BOTH = replace(MODEL, arm=replace(MODEL.arm, modes=[Mode(), Mode(frequency_hz=15.0, participation=-0.2)]))
PARTS = [f"{mode}.{part}" for mode in range(2) for part in "qv"]


def shown(values: dict[str, float], impacts: tuple[int, ...]) -> tuple[World, Array]:
    """A world, and a vector of it at which the arm rings while the joint moves."""
    world = World(empty(SECONDS, BOTH), BOTH, impacts)
    rings = {"jump.0.0.q": 0.02, "jump.1.0.v": 0.1}
    return world, world.space.with_values(world.space.vector(), rings | values)


def by_difference(world: World, vector: Array, name: str) -> dict[str, Array]:
    step = 1e-5
    before = world.predict(vector)
    after = world.predict(world.space.with_values(vector, {name: vector[world.space.place[name]] + step}))
    found = {one: (after.channels[one] - before.channels[one]) / step for one in before.channels}
    # the last sample of a sensor that is late is interpolated towards one that no recording holds
    return {one: slope[:-1] if one == "acceleration" else slope for one, slope in found.items()}


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@example(4, 4, "0.q", 0.0, 0.0, 0.0, 0.125, 0.0)  # while an image is exposed that the recording begins in
@given(
    impact=st.integers(1, 2990),
    other=st.integers(1, 2990),
    part=st.sampled_from(PARTS),
    delay_s=st.sampled_from([0.0, 0.0004, 0.003, 0.0137]),
    lag_s=st.sampled_from([0.0, 0.004]),
    bend=st.sampled_from([0.0, 0.5]),
    capture_s=st.floats(0.0, 0.2),
    tilt=st.sampled_from([0.0, 120.0]),
)
def test_it_is_the_difference_quotient(
    impact: int,
    other: int,
    part: str,
    delay_s: float,
    lag_s: float,
    bend: float,
    capture_s: float,
    tilt: float,
) -> None:
    impacts = tuple(sorted({impact, other, 2995}))
    values = {
        "accelerometer.range_m_s2": 1e6,  # no difference across a limit
        "accelerometer.delay_s": delay_s,
        "accelerometer.lag_s": lag_s,
        "accelerometer.lag_bend": bend,
        "timing.capture_delay_s": capture_s,
        "camera.rotation_px_per_rad": tilt,
    }
    world, vector = shown(values, impacts)
    for number in range(1, len(impacts) + 1):
        name = f"jump.{number}.{part}"
        found = world.slopes_of_jump(name, vector, world.predict(vector))
        if impacts[number - 1] < 4:
            assert found is None  # at the first samples an interpolation is another: left to differences
            continue
        assert found is not None
        expected = by_difference(world, vector, name)
        for channel, slope in expected.items():
            size = max(float(np.max(np.abs(slope))), 1e-12)
            mine = found.get(channel, np.zeros(len(slope)))[: len(slope)]
            assert mine == pytest.approx(slope, abs=1e-6 * size), channel


def test_a_reading_at_its_limit_does_not_move() -> None:
    world, vector = shown({"accelerometer.range_m_s2": 3.0}, (1200,))
    base = world.predict(vector)
    found = world.slopes_of_jump("jump.1.0.v", vector, base)
    assert found is not None
    limited = np.abs(base.channels["acceleration"]) >= 3.0
    assert limited[1200:].any()
    assert not found["acceleration"][limited].any()
    expected = by_difference(world, vector, "jump.1.0.v")["acceleration"]
    assert found["acceleration"][:-1] == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("jump.0.0.v", {}),  # the state at the start
        ("modes.0.frequency_hz", {}),
        ("jump.1.0.v", {"accelerometer.rate_per_s": 0.01}),
        ("jump.1.0.v", {"camera.lens_per_px2": 1e-5}),
        ("jump.1.0.v", {"camera.locking_sin_px": 0.1}),
        ("jump.1.0.v", {"arm.coulomb_m_s2": 0.1}),
    ],
)
def test_what_no_other_impact_tells_is_left_to_differences(name: str, values: dict[str, float]) -> None:
    world, vector = shown(values, (1200,))
    assert world.slopes_of_jump(name, vector, world.predict(vector)) is None
