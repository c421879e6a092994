"""The running mean against numpy's, with gaps."""

from math import isnan, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.controller.estimation.delay.moving_average import MovingAverage


@pytest.mark.slow
@given(
    values=st.lists(st.one_of(st.floats(-1e3, 1e3), st.just(nan)), min_size=1, max_size=80),
    length=st.integers(1, 9),
)
def test_mean_of_what_is_present(values: list[float], length: int) -> None:
    """NaN counts as no value; without any value the last mean is kept."""
    average, last = MovingAverage(length), 0.0
    for k, value in enumerate(values):
        window = [v for v in values[max(0, k + 1 - length) : k + 1] if not isnan(v)]
        last = float(np.mean(window)) if window else last
        assert average.add(value) == pytest.approx(last, abs=1e-8)
