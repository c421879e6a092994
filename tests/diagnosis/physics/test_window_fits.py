"""Least squares in windows, against NumPy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.diagnosis.physics.window_fits import least_squares, swings_in_windows

LEAST = 1e-9


@given(st.integers(0, 10_000), st.integers(1, 6), st.integers(0, 3))
def test_it_is_numpys_least_squares(seed: int, k: int, alike: int) -> None:
    """Also of columns that lie within others, and of units far apart."""
    random = np.random.default_rng(seed)
    n = 5 * k + 7
    terms = random.normal(size=(n, k)) * 10.0 ** random.uniform(-3.0, 3.0, k)
    for _ in range(alike):
        terms[:, random.integers(k)] = terms[:, random.integers(k)]
    values = random.normal(size=n)
    amounts = np.empty(k)
    left = least_squares(np.column_stack([terms, values]), LEAST, amounts)
    rest = values - terms @ np.linalg.lstsq(terms, values, rcond=LEAST)[0]
    assert left == pytest.approx(float(rest @ rest), rel=1e-6)
    mine = values - terms @ amounts
    assert float(mine @ mine) == pytest.approx(left, rel=1e-6)


def test_nothing_explains_nothing() -> None:
    amounts = np.empty(2)
    both = np.column_stack([np.zeros((8, 2)), np.arange(8.0)])
    assert least_squares(both, LEAST, amounts) == pytest.approx(140.0)
    assert not amounts.any()


def test_a_free_vibration_is_all_of_its_window_and_a_short_one_is_not_told() -> None:
    w, damping = 2.0 * np.pi * 2.6, 0.01
    time = np.arange(400) * 0.005
    swing = 0.03 * np.exp(-damping * w * time) * np.cos(w * time + 1.0)
    joint = np.sin(time)
    values = swing + 0.7 * joint + 0.2
    places, firsts = np.arange(405)[:400], np.array([0, 200, 395, 400])
    starts, left, size = np.array([0.0, 1.0, 1.975]), np.empty(3), np.empty(3)
    nothing = np.zeros(400)
    swings_in_windows(
        time, values, nothing, joint[:, None], places, firsts, starts, w, damping, LEAST, left, size
    )
    assert left[:2] == pytest.approx(0.0, abs=1e-12)
    assert size[0] == pytest.approx(float(np.std(swing[:200])), rel=1e-6)
    assert size[1] == pytest.approx(float(np.std(swing[200:395])), rel=1e-6)
    assert np.isnan(left[2]) and size[2] == 0.0
