"""CycleHistory against a plain list."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.controller.joint.history import CycleHistory


@given(steps=st.lists(st.integers(1, 4), min_size=1, max_size=60), length=st.integers(5, 20))
def test_lags_and_instants_match_a_list(steps: list[int], length: int) -> None:
    """Skipped cycles take the value of the one written next; only the last `length` are held."""
    history, plain, cycle = CycleHistory(length), {}, 0
    for k, step in enumerate(steps):
        for missed in range(1, step + 1):
            plain[cycle + missed] = float(k)
        cycle += step
        history.write(cycle, float(k))
    wanted = [plain.get(cycle - lag, 0.0) for lag in range(length)]
    assert history.lags(0, length - 1)[::-1].tolist() == wanted
    assert history.lags(2, 4)[::-1].tolist() == wanted[2:5]
    if length > 2 and cycle > 2:
        middle = history.at(cycle - 0.25)
        assert middle == pytest.approx(0.75 * wanted[0] + 0.25 * wanted[1])


def test_instants_outside_are_the_nearest_held() -> None:
    """Neither the future nor the forgotten past is extrapolated."""
    history = CycleHistory(4)
    for cycle in range(10):
        history.write(cycle, float(cycle))
    assert history.at(99.0) == 9.0
    assert history.at(-99.0) == 6.0
    assert np.isfinite(CycleHistory(3).at(1.5))


@given(gaps=st.lists(st.integers(1, 10**6), min_size=1, max_size=8), length=st.integers(3, 20))
def test_a_fill_is_as_writing_each_cycle(gaps: list[int], length: int) -> None:
    """For any length; a fill into the past changes nothing."""
    history, cycle = CycleHistory(length), 5
    history.write(cycle, 1.0)
    wanted = [0.0] * (length - 1) + [1.0]
    for k, gap in enumerate(gaps):
        cycle += gap
        history.fill(cycle, float(-k))
        history.fill(cycle - 3, 99.0)
        wanted = (wanted + [float(-k)] * min(gap, length))[-length:]
        assert history.lags(0, length - 1).tolist() == wanted
