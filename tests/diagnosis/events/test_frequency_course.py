"""How the arm's frequency goes is seen without a free run: a change, a stiffness; where it stays, nothing."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.events.frequency_course import Course, frequency_courses, seen_frequency
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, measured


def courses(values: dict[str, float], impacts: tuple[int, ...] = ()) -> dict[str, Course]:
    """What is seen of 20 s that these quantities made."""
    world = World(measured(20.0, 5, values, impacts), MODEL)
    return frequency_courses(world, world.predict(world.space.vector()).motion)


def test_one_frequency_has_no_course() -> None:
    assert courses({"modes.0.frequency_hz": 2.75, "jump.1.0.v": 0.3}, (9000,)) == {}


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.85, 0.93, 1.1])
def test_a_change_is_seen_across_an_impact(ratio: float) -> None:
    found = courses({"arm.onset_s": 9.0, "arm.frequency_ratio": ratio, "jump.1.0.v": 0.3}, (12000,))
    best = max(found, key=lambda cause: found[cause].nats)
    assert best == "payload_change"
    start = found[best].start
    assert start["arm.frequency_ratio"] == pytest.approx(ratio, rel=0.01)
    assert start["modes.0.frequency_hz"] == pytest.approx(MODEL.arm.modes[0].frequency_hz, rel=0.01)
    assert start["arm.onset_s"] == pytest.approx(9.0, abs=1.6)  # one window


def test_a_stiffness_is_seen_as_such() -> None:
    found = courses({"arm.cubic_per_m2": 150.0})
    best = max(found, key=lambda cause: found[cause].nats)
    assert best == "cubic_stiffness"
    assert found[best].start["arm.cubic_per_m2"] == pytest.approx(150.0, rel=0.5)


@pytest.mark.parametrize("felt", [np.nan, 0.0], ids=["images alone", "an accelerometer that shows nothing"])
def test_images_show_it_too(felt: float) -> None:
    data = measured(20.0, 5, {"arm.cubic_per_m2": 150.0})
    noise = np.random.default_rng(3).normal(0.0, 3.0, data.cycles)
    world = World(replace(data, acceleration=noise + felt), MODEL)
    found = frequency_courses(world, world.predict(world.space.vector()).motion)
    best = max(found, key=lambda cause: found[cause].nats)
    assert best == "cubic_stiffness"
    assert found[best].start["arm.cubic_per_m2"] == pytest.approx(150.0, rel=0.5)


@pytest.mark.slow
@pytest.mark.parametrize("hz", [2.2, 3.1])
def test_the_one_frequency_is_seen_from_far_off(hz: float) -> None:
    world = World(measured(20.0, 5, {"modes.0.frequency_hz": hz, "jump.1.0.v": 0.3}, (9000,)), MODEL)
    motion = world.predict(world.space.vector()).motion
    assert seen_frequency(world, motion, 2.5) == pytest.approx(hz, rel=0.01)
    assert seen_frequency(world, motion, hz) is None
