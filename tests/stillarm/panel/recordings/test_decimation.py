"""Fewer points that show the same curve: no peak is ever lost."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.panel.recordings.decimation import min_max


@given(
    st.lists(st.one_of(st.floats(-1e6, 1e6), st.just(float("nan"))), min_size=1, max_size=300),
    st.integers(1, 40),
)
def test_each_interval_keeps_its_least_and_greatest_value(values: list[float], intervals: int) -> None:
    times = np.arange(len(values)) * 1e-3
    column = np.array(values)
    thin_times, (thin,) = min_max(times, column[None], intervals)
    if len(values) <= 2 * intervals:
        assert np.array_equal(thin, column, equal_nan=True)
        return
    assert len(thin) == len(thin_times) == 2 * intervals
    edges = np.linspace(0, len(values), intervals + 1).astype(int)
    for number, (begin, end) in enumerate(pairwise(edges)):
        part, kept = column[begin:end], thin[2 * number : 2 * number + 2]
        if np.isnan(part).all():
            assert np.isnan(kept).all()
            continue
        assert sorted(kept) == [np.nanmin(part), np.nanmax(part)]
        if kept[0] != kept[1]:  # in the order in which they come
            first = [np.flatnonzero(part == value)[0] for value in kept]
            assert first[0] < first[1]
    assert (np.diff(thin_times) >= 0.0).all()


@pytest.mark.parametrize("place", [0, 1, 49_999, 50_000, 99_999])
def test_a_single_spike_among_a_hundred_thousand_is_drawn(place: int) -> None:
    column = np.zeros(100_000)
    column[place] = 7.0
    times, (thin,) = min_max(np.arange(100_000) * 1e-3, column[None], 500)
    assert thin.max() == 7.0
    assert abs(times[np.argmax(thin)] - place * 1e-3) <= 0.2
