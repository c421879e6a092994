"""The benchmark's closed loop: its plant against theory, its oracle against the damping that was asked for."""

import numpy as np
import pytest

from stillarm.benchmarks.estimators.closed_loop import NO_DAMPING, ORACLE, Course, run_closed
from stillarm.benchmarks.estimators.damping_table import settling_time_s
from stillarm.benchmarks.estimators.world.regimes import REGIMES, Arm

UNIT = Arm().amplitude_m


def test_the_oracle_settles_as_fast_as_the_added_damping_says() -> None:
    """0.01 of the arm's and 0.12 of the joint's: ten times smaller in ln 10 / (0.13 w), give or take a half period."""
    course = Course(24.0, dict.fromkeys((0.0, 8.0, 12.0, 16.0, 20.0), UNIT), damping=lambda t: t >= 5.0)
    regime = REGIMES["freerun drift"]
    run = run_closed(ORACLE, regime, 0.3, (1,), course)
    assert settling_time_s(run, UNIT) == pytest.approx(np.log(10.0) / (0.13 * 16.34), abs=0.1)
    assert np.isnan(settling_time_s(run_closed(NO_DAMPING, regime, 0.3, (1,), course), UNIT))


def test_methods_are_shown_the_same_disturbances_and_the_truth_about_delays() -> None:
    """Before damping sets in every run is the same; the constant delay of 74 ms is off by the reading's cycle only."""
    course = Course(3.0, {0.0: UNIT, 1.5: UNIT}, damping=lambda t: t >= 2.0)
    runs = [
        run_closed(name, REGIMES["freerun constant"], 0.3, (5,), course) for name in ("correlation", ORACLE)
    ]
    assert np.array_equal(runs[0].deflection_m[:2000], runs[1].deflection_m[:2000])
    assert not np.array_equal(runs[0].deflection_m, runs[1].deflection_m)
    assert np.max(np.abs(runs[1].delay_error_s)) < 0.0006  # the oracle says 74 ms
    assert np.array_equal(runs[1].predicted_m, runs[1].deflection_m)
