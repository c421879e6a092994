"""How many frames were lost, found from the arrivals alone: arrivals are made here, from what is known to be lost."""

import numpy as np
import pytest
from numpy.typing import NDArray

from stillarm.diagnosis.data.lost_frames import lost_before

Array = NDArray[np.float64]
RATE = 50.0
PERIOD = 1.0 / RATE


def gone(seed: int, count: int, fraction: float, run: float) -> NDArray[np.bool_]:
    """Which frames are lost: this fraction, in runs of this mean length (1: singly)."""
    random = np.random.default_rng((seed, 1))
    if run == 1.0:
        return np.asarray(random.random(count) < fraction)
    stay, now, out = 1.0 - 1.0 / run, False, np.zeros(count, bool)
    enter = fraction * (1.0 - stay) / (1.0 - fraction)
    for k in range(count):
        now = bool(random.random() < (stay if now else enter))
        out[k] = now
    return out


def arrivals(seed: int, count: int, jitter: float, skew_ppm: float = 0.0, wander_s: float = 0.0) -> Array:
    """Arrival of every frame, s, read in steps of 1 ms; jitter: deviation in periods."""
    random = np.random.default_rng((seed, 2))
    wander = np.zeros(count)
    for k in range(1, count):
        wander[k] = 0.98 * wander[k - 1] + 0.2 * wander_s * random.standard_normal()
    due = np.arange(count) * PERIOD * (1.0 + 1e-6 * skew_ppm) + 0.07 + wander
    return np.ceil((due + jitter * PERIOD * random.standard_normal(count)) / 1e-3) * 1e-3


def wrong(received: Array, lost: NDArray[np.bool_]) -> float:
    """Share of the frames that are numbered otherwise than they should be."""
    kept = np.flatnonzero(~lost)
    some = np.maximum.accumulate(received[kept])
    numbers = np.cumsum(1 + lost_before(some, np.ones(len(kept) - 1, np.int64), PERIOD))
    off = numbers - kept
    return float(np.mean(off != np.rint(np.median(off))))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1])
@pytest.mark.parametrize("run", [1.0, 1.5])
@pytest.mark.parametrize("fraction", [0.01, 0.14, 0.4])
@pytest.mark.parametrize("jitter", [0.05, 0.1])
def test_losses_are_found(fraction: float, run: float, jitter: float, seed: int) -> None:
    lost = gone(seed, 600, fraction, run)
    assert wrong(arrivals(seed, 600, jitter, wander_s=0.002), lost) < 0.03


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("fraction", [0.02, 0.2])
def test_also_where_arrivals_scatter_by_a_fifth_of_a_period(fraction: float, seed: int) -> None:
    assert wrong(arrivals(seed, 600, 0.2), gone(seed, 600, fraction, 1.0)) < 0.05


@pytest.mark.parametrize("skew_ppm", [-3000.0, 3000.0])
@pytest.mark.parametrize("fraction", [0.0, 0.01, 0.14])
def test_a_clock_that_runs_wrong_loses_nothing(fraction: float, skew_ppm: float) -> None:
    lost = gone(3, 600, fraction, 1.5)
    assert wrong(arrivals(3, 600, 0.05, skew_ppm), lost) < 0.03


@pytest.mark.parametrize("late_s", [0.005, 0.015, 0.035, 0.06, 0.08])
@pytest.mark.parametrize("fraction", [0.0, 0.05])
def test_a_burst_of_late_frames_is_no_loss(fraction: float, late_s: float) -> None:
    received, lost = arrivals(4, 600, 0.05), gone(4, 600, fraction, 1.5)
    for begin, length in ((150, 20), (400, 40), (560, 10)):
        received[begin : begin + length] += late_s
    # which of the frames that pile up at its end were lost is anyone's guess: they come at once
    assert wrong(received, lost) < 0.05


@pytest.mark.parametrize("jitter", [0.02, 0.1, 0.2])
def test_nothing_is_lost_where_nothing_was(jitter: float) -> None:
    for seed in range(3):
        received = np.maximum.accumulate(arrivals(seed, 600, jitter, wander_s=0.002))
        assert not lost_before(received, np.ones(599, np.int64), PERIOD).any()


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("jitter", [0.45, 0.63, 0.8])
def test_none_is_invented_where_arrivals_scatter_by_half_a_period_or_more(jitter: float, seed: int) -> None:
    """Frames in a queue: none overtakes the one before it. Invented losses would have the camera's clock skewed."""
    received = np.maximum.accumulate(arrivals(seed, 2000, jitter, wander_s=0.3 * PERIOD))
    assert not lost_before(received, np.ones(1999, np.int64), PERIOD).any()
