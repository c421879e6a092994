"""Decaying sinusoids in noise, written down apart: frequency and damping come out whatever the phases."""

from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from stillarm.diagnosis.calibration.ring_down import Stretch, peaks, ringing


def stretches(
    hz: float, ratio: float, seed: int, amplitude: float = 3.0, duration_s: float = 12.0
) -> list[Stretch]:
    """Two channels, one fast and noisy, one at a camera's rate, over two stretches of different length."""
    random = np.random.default_rng(seed)
    w = 2.0 * pi * hz
    found = []
    for length in (duration_s, 0.3 * duration_s):
        for step in (0.001, 1.0 / 65.0):
            t = np.arange(0.0, length, step)
            phase, offset = random.uniform(0.0, 2.0 * pi), random.normal(0.0, 5.0)
            ring = amplitude * np.exp(-ratio * w * t) * np.cos(w * sqrt(1.0 - ratio**2) * t + phase)
            found.append(Stretch(t, ring + offset + random.standard_normal(len(t))))
    return found


@settings(max_examples=8, deadline=None)
@example(hz=8.0, ratio=0.03, seed=316)  # over after a twentieth of the stretch
@given(hz=st.floats(1.0, 8.0), ratio=st.floats(0.002, 0.03), seed=st.integers(0, 1000))
def test_frequency_and_damping_are_found_from_the_peak(hz: float, ratio: float, seed: int) -> None:
    what = stretches(hz, ratio, seed)
    found = ringing(what, peaks(what)[0])
    assert found.frequency_hz == pytest.approx(hz, rel=0.005)
    assert found.damping_ratio == pytest.approx(ratio, rel=0.2, abs=0.0005)
    assert found.power > 0.1


def test_noise_alone_has_no_power() -> None:
    what = stretches(3.0, 0.01, 5, amplitude=0.0)
    assert abs(ringing(what, peaks(what)[0]).power) < 0.05


def test_two_modes_are_two_peaks() -> None:
    one, other = stretches(2.0, 0.005, 1), stretches(6.3, 0.005, 2)
    both = [Stretch(a.time_s, a.values + b.values) for a, b in zip(one, other, strict=True)]
    found = sorted(peaks(both, 2))
    assert found == pytest.approx([2.0, 6.3], rel=0.02)
