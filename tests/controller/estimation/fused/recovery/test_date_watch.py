"""Dates that are off shift the accelerometer's phase against images; no fault of the sensor does."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.controller.estimation.fused.recovery.date_watch import DateWatch

NOISE = 0.08  # of the amplitude, of a block: 0.3 of a sample over 16 samples
STEP = 2.0 * pi / 24.0


def watched(phase: float, ratio: float, offset: float, seed: int, blocks: int = 72) -> DateWatch:
    """Blocks of a sensor that shows `ratio` of the vibration, `phase` ahead of what images say, and an offset."""
    generator, watch = np.random.default_rng(seed), DateWatch()
    for k in range(blocks):
        shown = ratio * np.cos(STEP * k + phase) + offset + NOISE * generator.standard_normal()
        watch.see(float(shown), float(np.cos(STEP * k)), float(-np.sin(STEP * k)), NOISE**2)
    return watch


@settings(max_examples=40, deadline=None)
@given(
    phase=st.floats(0.25, 2.8), sign=st.sampled_from([-1.0, 1.0]), ratio=st.floats(0.8, 1.25),
    offset=st.floats(-0.5, 0.5), seed=st.integers(0, 1000),
)  # fmt: skip
def test_the_phase_that_dates_are_off_by_is_told(
    phase: float, sign: float, ratio: float, offset: float, seed: int
) -> None:
    """To four of its standard deviations, 0.02 rad, in three periods."""
    assert watched(sign * phase, ratio, offset, seed).lag_rad == pytest.approx(sign * phase, abs=0.1)


@pytest.mark.parametrize("ratio", [0.0, 0.4, 0.6, 1.7])
def test_another_gain_is_no_phase(ratio: float) -> None:
    """A sensor that is dead, or whose gain has changed."""
    assert watched(0.0, ratio, 0.2, 1).lag_rad == 0.0


def test_the_wrong_sign_is_no_date() -> None:
    """Half a period off, as a sensor looks that is mounted the wrong way round: the delay is never off by as much."""
    assert watched(0.0, -1.0, 0.0, 1).lag_rad == 0.0


@pytest.mark.slow
def test_right_dates_are_left_alone() -> None:
    """Two hundred sensors, 20 s each: noise alone gives no phase, nor a suspicion."""
    for seed in range(200):
        watch = DateWatch()
        generator = np.random.default_rng(seed)
        for k in range(1200):
            watch.see(
                float(np.cos(STEP * k) + NOISE * generator.standard_normal()),
                float(np.cos(STEP * k)), float(-np.sin(STEP * k)), NOISE**2,
            )  # fmt: skip
            assert watch.suspected_rad == 0.0


def test_suspected_first_and_forgotten_on_restart() -> None:
    """Told as a suspicion before it has lasted for three quarters of a period."""
    watch = watched(0.6, 1.0, 0.0, 3, blocks=20)
    assert watch.suspected_rad == pytest.approx(0.6, abs=0.15) and watch.lag_rad == 0.0
    watch.restart()
    assert watch.suspected_rad == 0.0


def test_a_vibration_too_small_to_see_tells_nothing() -> None:
    """A tenth of a block's noise."""
    generator, watch = np.random.default_rng(5), DateWatch()
    for k in range(2000):
        shown = 0.1 * NOISE * np.cos(STEP * k + 1.0) + NOISE * generator.standard_normal()
        watch.see(
            float(shown),
            0.1 * NOISE * float(np.cos(STEP * k)),
            -0.1 * NOISE * float(np.sin(STEP * k)),
            NOISE**2,
        )
        assert watch.lag_rad == 0.0
