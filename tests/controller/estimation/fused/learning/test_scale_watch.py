"""An image scale that drifts is seen and followed; noise, an impact and a spike are no drift."""

from dataclasses import replace
from math import pi, sin, sqrt

import numpy as np
import pytest

from stillarm.benchmarks.estimators.closed_loop import Course, run_closed
from stillarm.benchmarks.estimators.damping_table import steady_force_m_s2
from stillarm.benchmarks.estimators.trial import Score, assumed_model, run_method, scale_error, score
from stillarm.benchmarks.estimators.world.generator import Data, generate
from stillarm.benchmarks.estimators.world.regimes import REGIMES, Arm
from stillarm.controller.estimation.fused.learning.scale_watch import ScaleWatch

BLOCK_S, W = 0.016, 2.0 * pi * 2.6
NOISE = 0.3 / sqrt(16.0)  # of a block, of the amplitude


def seen_after(watch: ScaleWatch, error: float, seconds: float, seed: int) -> float:
    """Time until the watch finds the scale off where it is off by `error`, s; `seconds` where it does not."""
    random = np.random.default_rng(seed)
    for block in range(round(seconds / BLOCK_S)):
        expected = sin(W * block * BLOCK_S)
        difference = error * expected + NOISE * random.standard_normal()
        if watch.see(difference, expected, NOISE**2, BLOCK_S):
            return block * BLOCK_S
        watch.grown(BLOCK_S)
    return seconds


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_an_hour_of_noise_is_no_drift(seed: int) -> None:
    watch = ScaleWatch()
    assert seen_after(watch, 0.0, 3600.0, seed) == 3600.0
    assert watch.walk == 0.0


@pytest.mark.parametrize("error", [0.03, 0.05, 0.1, 0.2, 0.3])
def test_a_scale_that_is_off_is_found_as_soon_as_the_noise_lets_it(error: float) -> None:
    """The score of an error d grows as d sqrt(t / 2 / block) / noise: twice the alarm's 4.7 deviations are enough.

    Nine times in ten: chance makes the others later, of errors that are found within a period or two.
    """
    enough = 2.0 * BLOCK_S * (9.4 * NOISE / error) ** 2 / (1.0 - min(0.5, (0.025 / error) ** 2))
    soon, sized = [], []
    for seed in range(40):
        for sign in (-1.0, 1.0):
            watch = ScaleWatch()
            soon.append(seen_after(watch, sign * error, 60.0, seed) < max(enough, 0.4))
            sized.append(0.2 * error**2 < 4.0 * watch.walk < 9.0 * error**2)
    assert np.mean(soon) >= 0.9
    assert np.mean(sized) >= 0.95


def test_the_room_given_fades_once_the_scale_is_right_again() -> None:
    watch = ScaleWatch()
    assert seen_after(watch, 0.1, 60.0, 0) < 60.0
    room = watch.walk
    assert seen_after(watch, 0.0, 60.0, 1) == 60.0
    assert watch.walk == pytest.approx(room * np.exp(-3.0), rel=0.01)


def test_the_room_given_fades_when_nothing_more_is_seen() -> None:
    """As with an accelerometer that has died since."""
    watch = ScaleWatch()
    assert seen_after(watch, 0.1, 60.0, 0) < 60.0
    room = watch.walk
    grown = sum(watch.grown(BLOCK_S) for _ in range(round(60.0 / BLOCK_S)))
    assert watch.walk == pytest.approx(room * np.exp(-3.0), rel=0.01)
    assert grown == pytest.approx(room * 20.0 * (1.0 - np.exp(-3.0)), rel=0.01)


def test_a_drift_is_told_of_for_a_while() -> None:
    """From the alarm on, until what it gave room for has faded."""
    watch = ScaleWatch()
    assert not watch.drifts
    assert seen_after(watch, 0.1, 60.0, 0) < 60.0
    assert watch.drifts
    watch.grown(15.0)
    assert watch.drifts
    watch.grown(6.0)
    assert not watch.drifts


def test_impacts_and_spikes_do_not_count() -> None:
    """Of a size that alone would be an alarm."""
    watch = ScaleWatch()
    for block in range(1000):
        expected = sin(W * block * BLOCK_S)
        assert not watch.see(10.0 * NOISE if block % 50 == 0 else 0.0, expected, NOISE**2, BLOCK_S)


def test_a_vibration_too_small_to_tell_is_no_drift() -> None:
    """Departures that add up to more than any scale is off: it is not the scale."""
    watch = ScaleWatch()
    for block in range(2000):
        expected = 0.01 * sin(W * block * BLOCK_S)
        assert not watch.see(50.0 * expected, expected, NOISE**2, BLOCK_S)
    assert watch.walk == 0.0


def room_after(steps: float, seconds: float) -> float:
    """What is left of the room where the estimate, known to a tenth of it, steps by so many of its deviations."""
    watch, random, error = ScaleWatch(), np.random.default_rng(3), 0.0
    assert seen_after(watch, 0.1, 60.0, 0) < 60.0
    room, variance = watch.walk, 0.01 * watch.walk
    for frame in range(round(65.0 * seconds)):
        error += steps * sqrt(watch.grown(1.0 / 65.0)) * float(random.standard_normal())
        seen = error + sqrt(variance) * float(random.standard_normal())
        watch.see_scale(seen, variance, (1, 0))
        assert frame or watch.walk == pytest.approx(room, rel=1e-3)
    return watch.walk / room


def test_the_room_that_the_scale_does_not_use_is_taken_back() -> None:
    """Without its steps being looked at, 0.6 of the variance is left after ten seconds."""
    assert room_after(0.0, 10.0) < 0.02
    assert room_after(1.0, 10.0) > 0.1


def test_a_filter_that_was_moved_tells_nothing_of_the_room() -> None:
    watch = ScaleWatch()
    assert seen_after(watch, 0.1, 60.0, 0) < 60.0
    room, grown = watch.walk, 0.0
    for moved in range(20):
        grown += watch.grown(0.6)
        watch.see_scale(0.0, 1e-6, (1, moved))
    assert watch.walk == pytest.approx(room * (1.0 - 0.6 / 20.0) ** 20)


@pytest.mark.slow
def test_a_steady_random_force_is_no_drift() -> None:
    """It moves what images and accelerometer show; taken for a drift it left 0.121 of the amplitude."""
    arm = Arm()
    force = steady_force_m_s2(arm)
    course = Course(40.0, {0.0: arm.amplitude_m}, damping=lambda t: t >= 5.0, force_std_m_s2=force)
    run = run_closed("fused", REGIMES["triggered jitter"], 0.3, (83021, 1, 2), course)
    assert np.sqrt(np.mean(run.deflection_m[10_000:] ** 2)) < 0.112 * arm.amplitude_m


def drifting(share: float) -> Data:
    """A scene that comes nearer by that share within 20 s, from 10 s on."""
    data = generate(REGIMES["freerun drift"], 0.3, (311, 0, 1), 40.0, Arm())
    return replace(
        data, seen_m=data.seen_m * (1.0 + share * np.clip((data.frames.exposed_s - 10.0) / 20.0, 0.0, 1.0))
    )


@pytest.fixture(scope="module")
def score_of_drift() -> Score:
    data = drifting(0.2)
    answers = run_method("fused", data, assumed_model(data.regime, 0.3), 1.0 + scale_error((311, 0, 1)))
    return score(data, answers)


@pytest.mark.slow
def test_a_scene_that_comes_nearer_is_followed(score_of_drift: Score) -> None:
    """Without the watch the mean error is 3 % and the normalised error squared 12."""
    assert score_of_drift.error_mean < 0.015
    assert score_of_drift.error_last < 0.015
    assert score_of_drift.deflection_normalised_error_squared < 3.0
