"""The oracle's error against what the theory of estimation says of it, and against samples without noise."""

from math import pi, sqrt

import numpy as np
import pytest

from stillarm.benchmarks.live.bound import bound_of, oracle_deflection
from tests.fixtures.live_rows import W, true_run


def _samples(noise_m_s2: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    truth = true_run()
    time_s = np.arange(0.0, truth.time_s[-1], 0.001)
    step_s = truth.time_s[1] - truth.time_s[0]
    true = np.interp(time_s, truth.time_s, np.gradient(np.gradient(truth.deflection_m, step_s), step_s))
    return time_s, true + noise_m_s2 * np.random.default_rng(seed).standard_normal(len(time_s))


def test_samples_without_noise_leave_no_error_and_lost_ones_do_no_harm() -> None:
    time_s, samples = _samples(0.0)
    samples[::3] = np.nan
    assert bound_of(true_run(), time_s, samples) == pytest.approx(0.0, abs=1e-9)
    assert bound_of(true_run(), time_s, 2.0 * samples, scale=2.0) == pytest.approx(0.0, abs=1e-9)


def test_the_shift_has_the_deviation_of_the_cramer_rao_bound() -> None:
    """Of 60 draws of noise, the shift at 4 s; the theory's value from the samples' own slope."""
    truth = true_run()
    time_s, clean = _samples(0.0)
    begin = truth.swings[0].begin_s
    until = begin + 4.0
    part = (time_s > begin + 0.05) & (time_s <= until)
    expected_s = 0.5 / sqrt(float(np.sum(np.gradient(clean, time_s)[part] ** 2)))
    at = int(np.searchsorted(time_s, until))
    true = np.interp(time_s, truth.time_s, truth.deflection_m)
    speed = np.gradient(true, time_s)
    at += int(np.argmax(np.abs(speed[at : at + 400])))  # where the error shows best
    shifts = [
        (oracle_deflection(truth, *_samples(0.5, seed))[at] - true[at]) / speed[at] for seed in range(60)
    ]
    assert np.std(shifts) == pytest.approx(expected_s, rel=0.3)


def test_the_mean_error_is_that_of_the_shift() -> None:
    """A shift of e rad is a mean error of 2 e / pi; averaged over draws, with |e| of a normal law."""
    found = [bound_of(true_run(), *_samples(0.5, seed)) for seed in range(20)]
    known = [one for one in found if one is not None]
    assert len(known) == len(found)
    assert 0.0 < float(np.mean(known)) < 2.0 / pi * W * 2e-3
