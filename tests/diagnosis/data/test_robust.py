"""Deviations that outliers do not move."""

import numpy as np
import pytest

from stillarm.diagnosis.data.robust import (
    bridged,
    std_about_median,
    std_about_zero,
    step_at,
    white_noise,
    without_spikes,
)


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


@pytest.mark.parametrize("order", [2, 3, 4, 5])
def test_differences_show_the_noise_on_a_slow_motion(order: int) -> None:
    """On one period of a sine over four thousand samples, some of them missing."""
    slow = np.sin(2.0 * np.pi * np.arange(4000) / 4000.0)
    noisy = slow + np.random.default_rng(5).normal(0.0, 1e-3, 4000)
    noisy[[7, 8, 400]] = np.nan
    assert white_noise(noisy, order) == pytest.approx(1e-3, rel=0.06)


def test_nothing_known_has_no_noise() -> None:
    assert white_noise(np.full(9, np.nan)) == 0.0
    assert white_noise(np.zeros(3)) == 0.0


def test_gaps_are_bridged_straight_and_held_at_the_ends() -> None:
    gaps = np.array([np.nan, 1.0, np.nan, np.nan, 4.0, np.nan])
    assert bridged(gaps) == pytest.approx([1.0, 1.0, 2.0, 3.0, 4.0, 4.0])
    assert len(bridged(np.full(3, np.nan))) == 0


@pytest.mark.parametrize("wide", [1, 2])
def test_spikes_go_and_a_vibration_stays(wide: int) -> None:
    random, time = np.random.default_rng(4), np.arange(5000) * 0.001
    swing = 30.0 * np.sin(2.0 * np.pi * 3.0 * time) + random.normal(size=len(time))
    spiked = swing.copy()
    at = np.arange(50, 4950, 200)
    for i in range(wide):
        spiked[at + i] += 400.0
    found = without_spikes(spiked)
    assert np.max(np.abs(found - swing)) < 10.0
    untouched = np.ones(len(time), bool)
    untouched[np.add.outer(at, np.arange(wide)).ravel()] = False
    assert np.array_equal(found[untouched], swing[untouched])


def test_missing_values_are_no_neighbours_of_a_spike() -> None:
    clean = np.sin(np.arange(60.0))
    spiked = clean.copy()
    spiked[30] += 50.0
    known = np.ones(90, bool)
    known[::3] = False
    gapped = np.full(90, np.nan)
    gapped[known] = spiked
    without = without_spikes(gapped)
    assert np.isnan(without[~known]).all()
    assert without[known] == pytest.approx(without_spikes(spiked))
    assert abs(without[known][30]) < 2.0
