"""Samples during an impact are distinguished from a noisy vibration."""

from math import isnan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.controller.estimation.delay.impact_samples import ImpactSamples
from stillarm.controller.estimation.delay.moving_average import MovingAverage

PER_CYCLE = 2.0 * np.pi * 2.6 * 0.001


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 6.0), st.sampled_from([-1.0, 1.0]))
def test_an_impact_is_left_out_and_almost_nothing_else(seed: int, phase: float, sign: float) -> None:
    """Six samples of three amplitudes at noise 0.3, in five seconds of vibration."""
    noise = 0.3 * np.random.default_rng(seed).standard_normal(5000)
    signal = np.sin(PER_CYCLE * np.arange(5000) + phase) + noise
    signal[3000:3006] += sign * 4.0
    impacts, average = ImpactSamples(0.3, 32, PER_CYCLE), MovingAverage(65)
    left_out = []
    for cycle, value in enumerate(signal.tolist()):
        kept = impacts.without(value)
        impacts.see_average(average.add(kept))
        if isnan(kept):
            left_out.append(cycle)
    assert sum(3000 <= cycle < 3006 for cycle in left_out) >= 4
    assert sum(not 3000 <= cycle < 3006 and cycle > 500 for cycle in left_out) <= 3


def test_what_lasts_is_no_impact() -> None:
    """A step of the sensor's offset: its samples are back after forty cycles."""
    impacts, average = ImpactSamples(0.01, 32, PER_CYCLE), MovingAverage(65)
    kept = []
    for cycle in range(400):
        kept.append(impacts.without(0.0 if cycle < 200 else 1.0))
        impacts.see_average(average.add(kept[-1]))
    assert isnan(kept[210])
    assert kept[250] == 1.0
