"""Deviations that outliers do not move."""

import numpy as np
import pytest

from stillarm.diagnosis.robust import std_about_median, std_about_zero, step_at


def test_normal_values_have_their_standard_deviation_whatever_a_few_outliers_do() -> None:
    """The median absolute deviation over that of the normal law."""
    values = np.random.default_rng(3).normal(0.0, 0.7, 20_000)
    values[:200] = 1e6
    assert std_about_zero(values) == pytest.approx(0.7, rel=0.03)
    assert std_about_median(values + 5.0) == pytest.approx(0.7, rel=0.03)
    assert std_about_zero(values + 5.0) > 4.0


def test_a_step_is_seen_past_outliers_and_missing_values_and_near_either_end() -> None:
    """0.5 from place 40 on."""
    values = np.where(np.arange(60) >= 40, 0.5, 0.0)
    values[[38, 44]], values[[33, 47]] = 1e6, np.nan
    assert step_at(values, 40, 15) == 0.5
    assert step_at(values[39:], 1, 15) == 0.5
    assert step_at(values[:41], 40, 15) == 0.5
