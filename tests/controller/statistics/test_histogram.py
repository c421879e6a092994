"""The histogram of durations against numpy's percentiles."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stillarm.controller.statistics.histogram import (
    BINS,
    MicrosecondHistogram,
    bin_of,
    bin_start_us,
    percentiles_us,
)


def test_percentiles_to_a_microsecond() -> None:
    """For a long-tailed distribution; the maximum is exact, also beyond the bins."""
    durations = np.random.default_rng(1).exponential(80e-6, 20_000)
    histogram = MicrosecondHistogram()
    for duration in durations:
        histogram.add(float(duration))
    found = histogram.summary()
    wanted = np.percentile(durations * 1e6, (50.0, 99.0, 99.9))
    assert np.allclose(found[:3], wanted, atol=1.5)
    assert abs(found[3] - durations.max() * 1e6) < 0.002
    histogram.add(5.0)
    histogram.add(-1.0)
    assert histogram.summary()[3] == 5e6
    assert sum(histogram.counts()) == 20_002


@given(st.integers(-5, 2**30))
def test_every_duration_falls_into_the_bin_that_holds_it(microseconds: int) -> None:
    """To a 64th of it; the last bin takes the rest."""
    place = bin_of(microseconds)
    assert 0 <= place < BINS
    start = bin_start_us(place)
    assert start <= max(microseconds, 0)
    if place < BINS - 1:
        assert microseconds < bin_start_us(place + 1) <= start + max(1, start // 64)


def test_an_empty_one_says_zero() -> None:
    """Not an error: a loop may end before its first cycle."""
    assert MicrosecondHistogram().summary() == (0.0, 0.0, 0.0, 0.0)


@given(st.lists(st.integers(0, 9), min_size=1, max_size=40), st.floats(0.01, 1.0))
def test_percentiles_of_counts(counts: list[int], share: float) -> None:
    """The smallest bin with at least that share at or below it."""
    (found,) = percentiles_us(counts, (share,))
    if sum(counts) == 0:
        assert found == 0.0
        return
    below = np.cumsum(counts)
    assert below[int(found)] >= share * below[-1]
    assert found == 0.0 or below[int(found) - 1] < share * below[-1] or counts[int(found)] == 0
