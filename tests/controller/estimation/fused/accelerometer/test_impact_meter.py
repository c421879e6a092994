"""A strike is measured from the samples it adds to; what is none is left alone."""

from math import cos, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.benchmarks.estimators.trial import assumed_model, run_method
from stillarm.benchmarks.estimators.world.generator import generate
from stillarm.benchmarks.estimators.world.regimes import REGIMES, Arm
from stillarm.controller.estimation.fused.accelerometer.impact_meter import ForceStep, ImpactMeter

W, CYCLE_S = 16.3, 0.001
NOISE = 0.3


def watch(excess: list[float], std: float = NOISE) -> list[Any]:
    meter = ImpactMeter(W, CYCLE_S)
    found = [meter.see(cycle, value, std) for cycle, value in enumerate(excess)]
    return [one for one in found if one is not None]


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    begun=st.floats(200.0, 201.0),
    width=st.floats(4.0, 14.0),
    size=st.floats(3.0, 8.0),
    sign=st.sampled_from((-1.0, 1.0)),
    round_top=st.booleans(),
    seed=st.integers(0, 99),
)
def test_size_and_instant_lie_within_what_is_said(
    begun: float, width: float, size: float, sign: float, round_top: bool, seed: int
) -> None:
    """Rectangles and half sines of 4 to 14 ms that start and end between samples."""
    random = np.random.default_rng(seed)
    samples = []
    for cycle in range(260):
        within = (cycle - begun) / width
        shape = (sin(pi * within) if round_top else 1.0) if 0.0 < within < 1.0 else 0.0
        samples.append(sign * size * shape + NOISE * random.standard_normal())
    found = watch(samples)
    assert len(found) == 1
    area = sign * size * width * (2.0 / pi if round_top else 1.0)
    assert abs(found[0].sum_m - area) < 4.0 * found[0].sum_std_m
    assert abs(found[0].cycle - begun - 0.5 * width) < 4.0 * found[0].cycle_std


def test_noise_and_wild_samples_are_no_strike() -> None:
    """A minute of noise, with one or two neighbours off by thirty deviations every half second."""
    random = np.random.default_rng(1)
    samples = NOISE * random.standard_normal(60_000)
    for place in range(500, 60_000, 500):
        samples[place : place + 1 + place % 2] += 9.0
    assert watch(samples.tolist()) == []


@pytest.mark.parametrize("hz", [2.6, 14.0, 40.0])
def test_a_vibration_that_was_not_expected_is_no_strike(hz: float) -> None:
    """As of a mode that the model lacks, or of a sensor that is dead."""
    random = np.random.default_rng(2)
    samples = [1.5 * cos(2 * pi * hz * CYCLE_S * k) + NOISE * random.standard_normal() for k in range(20_000)]
    assert watch(samples) == []


def test_a_force_that_stays_is_a_step() -> None:
    """Let go, the arm is beside its place of rest by the force's deflection: the accelerometer shows it at once.

    And a strike with a sample missing in it is not measured.
    """
    assert watch([0.0] * 50 + [3.0] * 30) == [ForceStep(50, -3.0)]
    meter = ImpactMeter(W, CYCLE_S)
    found = [
        meter.see(cycle, 3.0 if 50 <= cycle < 57 else 0.01, NOISE) for cycle in range(100) if cycle != 54
    ]
    assert found == [None] * 99


def steps(excess: list[float]) -> list[ForceStep]:
    return [one for one in watch(excess) if isinstance(one, ForceStep)]


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    begun=st.integers(100, 160),
    size=st.floats(2.0, 20.0),
    sign=st.sampled_from((-1.0, 1.0)),
    seed=st.integers(0, 99),
)
def test_a_step_of_force_is_told_with_its_size_sign_and_instant(
    begun: int, size: float, sign: float, seed: int
) -> None:
    """The arm then swings about its new place of rest: a cosine, whose mean over 0.35 rad is 0.98 of its beginning.

    An onset told two cycles early takes another two twenty-firsts off that mean.
    """
    random = np.random.default_rng(seed)
    samples = NOISE * random.standard_normal(begun + 200)
    samples[begun:] += sign * size * np.cos(W * CYCLE_S * np.arange(200))
    (step, *_) = steps(samples.tolist())
    assert abs(step.cycle - begun) <= 3
    noise = 4.0 * NOISE / sqrt(20.0)
    assert (1.0 - 2.0 / 21.0) * 0.98 * size - noise < -sign * step.size_m < 0.98 * size + noise


def test_a_step_within_a_samples_noise_is_left_to_the_images() -> None:
    assert steps([0.0] * 60 + [3.9 * NOISE] * 60) == []
    assert len(steps([0.0] * 60 + [4.1 * NOISE] * 60)) == 1


@pytest.mark.parametrize(
    ("before", "told"),
    [
        ([0.1] * 21, True),
        ([2.0] * 21, False),  # an expectation that is off
        ([2.0] * 11 + [-2.0] * 10, False),  # a higher mode: its mean is zero, its halves are not
        ([], False),  # nothing is known of it
    ],
)
def test_only_a_sensor_that_was_still_before_shows_a_step(before: list[float], told: bool) -> None:
    """Watched from the step on: what was before it has raised no alarm by itself."""
    meter = ImpactMeter(W, CYCLE_S)
    first = 100
    meter._recent.extend((first - len(before) + k, value) for k, value in enumerate(before))
    meter._up_since = first
    found = [meter.see(first + k, 3.0, NOISE) for k in range(40)]
    assert [one for one in found if one is not None] == ([ForceStep(first, -3.0)] if told else [])


def test_what_dies_away_or_grows_while_it_is_watched_is_no_step() -> None:
    """A push by hand of 60 ms, as half a sine; a force that goes on to grow."""
    push = [5.0 * sin(pi * k / 60.0) for k in range(60)]
    assert steps([0.0] * 60 + push + [0.0] * 40) == []
    assert steps([0.0] * 60 + [0.3 * k for k in range(60)]) == []


def test_the_step_of_a_sensor_that_goes_on_is_told_once() -> None:
    """The arm rings about its new place: what is expected of it is right from then on."""
    assert steps([0.0] * 60 + [3.0] * 24 + [0.0] * 100) == [ForceStep(60, -3.0)]


@pytest.mark.slow
def test_the_deflection_is_known_while_the_images_still_show_the_time_before_the_impact() -> None:
    """From 15 ms behind an impact on, images being 74 ms late: within 12 percent, where it has moved by half."""
    regime = REGIMES["freerun drift"]
    data = generate(regime, 0.3, (31,), 10.0, Arm())
    said = run_method("fused", data, assumed_model(regime, 0.3))
    error = np.abs(said.deflection_m - data.deflection_m) / data.amplitude_m
    impacts = data.motion.impacts_s[data.motion.impacts_s < 9.5]
    assert len(impacts) >= 2
    for impact in impacts:
        behind = round(impact / 0.001)
        assert np.max(error[behind + 15 : behind + 100]) < 0.12
