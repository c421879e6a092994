"""The histogram of durations against numpy's percentiles."""

import numpy as np

from controller.histogram import MicrosecondHistogram


def test_percentiles_to_a_microsecond() -> None:
    """Of a long-tailed law; the greatest is exact, and beyond the bins too."""
    durations = np.random.default_rng(1).exponential(80e-6, 20_000)
    histogram = MicrosecondHistogram()
    for duration in durations:
        histogram.add(float(duration))
    found = histogram.summary()
    wanted = np.percentile(durations * 1e6, (50.0, 99.0, 99.9))
    assert np.allclose(found[:3], wanted, atol=1.5)
    assert found[3] == durations.max() * 1e6
    histogram.add(5.0)
    histogram.add(-1.0)
    assert histogram.summary()[3] == 5e6


def test_an_empty_one_says_zero() -> None:
    """Not an error: a loop may end before its first cycle."""
    assert MicrosecondHistogram().summary() == (0.0, 0.0, 0.0, 0.0)
