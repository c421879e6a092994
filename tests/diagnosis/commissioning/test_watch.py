"""What the watch sees, sample by sample, and how far a probe's growth goes by it."""

from dataclasses import replace
from math import nan

import pytest

from stillarm.diagnosis.commissioning.plan import stages
from stillarm.diagnosis.commissioning.watch import Bounds, Watch, bounds_of, growth
from tests.fixtures.probed import LIMITS, measured

BOUNDS = Bounds(angle_rad=0.05, image_px=100.0, acceleration_m_s2=10.0)


@pytest.mark.parametrize(
    ("samples", "expected"),
    [
        ([(0.0, 0.1, 0.2), (0.001, 0.1, 0.26)], "the joint is 0.060 rad from its start"),
        ([(0.0, 0.1, 0.0), (0.001, -11.0, 0.0)], "the accelerometer shows 11 m/s"),
        ([(0.0, nan, nan), (0.001, 9.0, 0.049)], None),
    ],
)
def test_a_cycle_s_samples(samples: list[tuple[float, float, float]], expected: str | None) -> None:
    watch = Watch(BOUNDS)
    for sample in samples:
        watch.cycle(*sample)
    assert watch.exceeded is None if expected is None else expected in str(watch.exceeded)


def test_images_that_go_far_or_stay_away() -> None:
    watch = Watch(BOUNDS)
    watch.image(0.0, 200.0)
    watch.image(0.1, 299.0)
    assert watch.exceeded is None
    watch.image(0.2, 301.0)
    assert watch.exceeded == "the image has moved by 101 px"
    away = Watch(BOUNDS)
    away.image(0.0, 0.0)
    away.cycle(0.4, 0.0, 0.0)
    assert away.exceeded is None
    away.cycle(0.6, 0.0, 0.0)
    assert away.exceeded == "no image was measured for 0.5 s"


def test_the_first_thing_exceeded_is_the_one_told() -> None:
    watch = Watch(BOUNDS)
    watch.cycle(0.0, 20.0, 0.0)
    watch.cycle(0.1, 0.0, 5.0)
    assert "accelerometer" in str(watch.exceeded)


@pytest.mark.slow
def test_growth_ends_before_the_stage_that_is_too_much() -> None:
    """Image, sensor, images lost; or nothing, and then it goes all the way."""
    plan, bounds = stages(LIMITS), bounds_of(LIMITS, 19.6)
    speeds = [stage.velocity_rad_s for stage in plan]
    whole = growth(measured(100.0, 10.0), plan, bounds)
    assert whole.velocity_rad_s == speeds[-1] and whole.ended_by is None
    seen = growth(measured(120.0 / (1.5 * speeds[2]), 1.0), plan, bounds)
    assert seen.velocity_rad_s == speeds[2] and "image" in str(seen.ended_by)
    felt = growth(measured(1.0, 11.26 / (1.5 * speeds[1])), plan, bounds)
    assert felt.velocity_rad_s == speeds[1] and "accelerometer" in str(felt.ended_by)
    lost = growth(measured(1.0, 1.0, plan[2].start_s + 1.0), plan, bounds)
    assert lost.velocity_rad_s == speeds[1] and "no image" in str(lost.ended_by)


def test_a_probe_that_was_cut_off_counts_up_to_its_last_whole_stage() -> None:
    plan = stages(LIMITS)
    whole = measured(1.0, 1.0)
    n = round((plan[2].end_s - 1.0) / 0.001)
    cut = replace(
        whole, command=whole.command[:n], acceleration=whole.acceleration[:n], position=whole.position[:n]
    )
    assert growth(cut, plan, bounds_of(LIMITS, 19.6)).velocity_rad_s == plan[1].velocity_rad_s
