"""Scores of the live benchmark against errors that are known beforehand, and commands that break their limits."""

from dataclasses import replace
from math import nan, pi

import numpy as np
import pytest

from stillarm.benchmarks.live.scoring import period_s, score
from tests.fixtures.live_rows import DELAY_S, W, perfect, true_run


def test_a_perfect_estimate_has_no_error() -> None:
    found = score(perfect(true_run()), true_run())
    for key in ("error_mean", "error_max", "lost_share", "settled_s", "longest_beyond_2_std_s"):
        assert found[key] == pytest.approx(0.0, abs=1e-9), key
    for key in ("delay_rms_s", "delay_mean_s", "delay_normalised_error_squared_max"):
        assert found[key] == pytest.approx(0.0, abs=1e-9), key
    assert period_s(true_run()) == pytest.approx(0.4, abs=0.003)


def test_an_error_in_proportion_to_the_amplitude_is_told_as_that_share() -> None:
    """A phase error of e rad is an error of e times the amplitude, 2 e / pi on average."""
    truth = true_run()
    said = perfect(truth)
    early = np.interp(said.time_s + 0.1 / W, truth.time_s, truth.deflection_m)
    found = score(replace(said, deflection_m=early), truth)
    assert found["error_mean"] == pytest.approx(0.2 / pi, rel=0.1)
    assert found["error_max"] == pytest.approx(0.1, rel=0.35)  # the decay makes up for the rest


def test_what_was_not_said_counts_as_an_error_of_the_whole_amplitude() -> None:
    truth = true_run()
    said = perfect(truth)
    found = score(replace(said, deflection_m=np.full(len(said.time_s), nan)), truth)
    assert found["error_mean"] == 1.0 and found["lost_share"] == 1.0
    assert found["longest_beyond_2_std_s"] is None


def test_the_normalised_error_is_that_of_the_worst_window() -> None:
    """Three deviations off in one window of the delay, one everywhere else."""
    truth = true_run()
    said = perfect(truth)
    off = np.where((said.received_s >= 7.0) & (said.received_s < 12.0), 3e-3, 1e-3)
    found = score(replace(said, delay_s=DELAY_S + off), truth)
    assert found["delay_normalised_error_squared_max"] == pytest.approx(9.0, rel=1e-6)
    assert found["deflection_normalised_error_squared_max"] == pytest.approx(0.0, abs=1e-9)


def test_a_time_beyond_two_deviations_is_not_ended_by_the_errors_crossings_of_zero() -> None:
    """An error in quadrature from 5 to 7 s, of ten deviations; and a spike of 20 ms elsewhere."""
    truth = true_run()
    said = perfect(truth)
    t = said.time_s
    wrong = np.where((t >= 5.0) & (t < 7.0), 1e-3 * np.cos(W * t), 0.0) + np.where(
        (t > 10.0) & (t < 10.02), 1e-3, 0.0
    )
    found = score(replace(said, deflection_m=said.deflection_m + wrong), truth)
    assert found["longest_beyond_2_std_s"] == pytest.approx(2.0, abs=0.06)
    spike = np.where((t > 10.0) & (t < 10.02), 1e-3, 0.0)
    found = score(replace(said, deflection_m=said.deflection_m + spike), truth)
    assert found["longest_beyond_2_std_s"] == pytest.approx(0.02, abs=0.003)
