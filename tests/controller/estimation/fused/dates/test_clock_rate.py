"""A clock that does not run at the nominal rate: refuted by arrivals that run away from it, and its rate learnt."""

from math import exp, sqrt

import msgspec
import numpy as np
import pytest

from stillarm.common.files.configuration import Controller as Settings
from stillarm.controller.estimation.fused.dates.clock_rate import ClockRate, Rate
from stillarm.controller.estimation.fused.filters.laws import Law
from stillarm.controller.estimation.fused.method import FusedMethod
from tests.reference.ringing_world import judge, model_for, ring

FRAME_S, SPREAD_S = 1.0 / 65.0, 0.0064
AMPLITUDE = 0.006


def wander(frames: int, seed: int) -> np.ndarray:
    """A delay that wanders by its spread in 5 s."""
    random, keep = np.random.default_rng(seed), exp(-FRAME_S / 5.0)
    delays = np.empty(frames)
    now = random.standard_normal()
    for k in range(frames):
        delays[k] = now
        now = keep * now + sqrt(1.0 - keep * keep) * random.standard_normal()
    return SPREAD_S * delays


def watch(differences: np.ndarray) -> tuple[int, Rate] | None:
    """The frame at which the clock is refuted, and its rate."""
    rate = ClockRate(SPREAD_S, 0.001)
    for k, difference in enumerate(differences.tolist()):
        found = rate.add(k * FRAME_S, difference)
        if found is not None:
            return k, found
    return None


@pytest.mark.parametrize("seed", range(5))
def test_a_delay_that_wanders_refutes_no_clock(seed: int) -> None:
    """Ten minutes of it, with jitter as large, a skew of 200 ppm for half a minute, and a buffer that begins to hand
    over frames two periods old.
    """
    jitter = SPREAD_S * np.random.default_rng(seed + 10).standard_normal(39_000)
    assert watch(wander(39_000, seed) + jitter) is None
    k = np.arange(2000)
    assert watch(wander(2000, seed) + 2e-4 * FRAME_S * k) is None
    assert watch(wander(2000, seed) + np.where(k > 1000, 2.0 * FRAME_S, 0.0)) is None


@pytest.mark.parametrize("rate", [-0.025, -0.004, 0.004, 0.012, 0.05])
def test_a_steady_recession_is_found_and_its_rate_told(rate: float) -> None:
    """Within the time in which it exceeds what a delay wanders, by far; the rate within what is stated."""
    ratios = []
    for seed in range(8):
        found = watch(wander(4000, seed) + rate * FRAME_S * np.arange(4000))
        assert found is not None
        frame, said = found
        assert frame * FRAME_S < max(4.5, 0.12 / abs(rate))
        assert said.std < 0.5 * abs(rate)
        ratios.append((said.rate - rate) / said.std)
    assert np.mean(np.square(ratios)) < 4.0


def test_lost_frames_from_a_count_of_arrivals_are_no_clock() -> None:
    """Every sixth one: 18 % is no rate that a clock has."""
    assert watch(FRAME_S * (np.arange(4000) // 5)) is None


@pytest.mark.slow
@pytest.mark.parametrize("delay", ["constant", "white"])
def test_a_camera_faster_than_its_nominal_rate_is_dated_by_its_own_clock(delay: str) -> None:
    """66.6 frames a second instead of 65: the clock is refuted as it was supposed, and learnt as it is."""
    model = model_for(AMPLITUDE, 0.3)
    faster = msgspec.structs.replace(
        model, camera=msgspec.structs.replace(model.camera, frame_rate_hz=65.0 * 1.025)
    )
    trial = ring(faster, 31, 14.0, delay=delay, excitation="strikes")
    method = FusedMethod(model, Settings().fused, "model")
    said = judge(method, model, trial)
    assert method.frames.evidence.law(Law.CLOCK) > 0.9
    assert not method.frames.state.health.mute
    late = said.delay_time > 9.0
    assert np.sqrt(np.mean(said.delay_error[late] ** 2)) < 0.0011
    assert 0.05 < np.mean((said.delay_error[late] / said.delay_std[late]) ** 2) < 4.0
