"""The shift of a signal that a fit of a sensor's delay begins at."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.diagnosis.driven.mechanisms.shifts import best_shift


@given(st.integers(-40, 40), st.integers(0, 2**32 - 1))
def test_it_is_the_delay_of_what_varies_at_random(shift: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    whole = random.standard_normal(600)
    simulated = whole[100:500]
    measured = whole[100 - shift : 500 - shift] + 0.1 * random.standard_normal(400) + 3.0
    assert best_shift(measured, simulated, 50) == shift


def test_no_longer_shift_than_allowed_and_gaps_do_not_count() -> None:
    time_s = np.arange(500) * 0.01
    simulated = np.sin(2.0 * np.pi * 0.9 * time_s)
    measured = np.sin(2.0 * np.pi * 0.9 * (time_s - 0.2))
    measured[100:120] = np.nan
    assert best_shift(measured, simulated, 30) == pytest.approx(20, abs=1)
    assert best_shift(measured, simulated, 5) == 5
