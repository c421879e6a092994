"""A start whose simulation runs away: friction that drives a joint on."""

import warnings

import numpy as np

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, runs_away
from stillarm.diagnosis.driven.mechanisms.mechanisms import FORMS
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven, Output
from stillarm.diagnosis.driven.search.from_start import fitted_from
from stillarm.diagnosis.driven.starts.start import linear_start
from tests.fixtures.current_joint import STEP_S, drive_input, moved

SQUARE = next(one for one in FORMS if one.numbers == ("viscous_square",))


def _start() -> DrivenFit:
    u = drive_input()
    angle, _ = moved(u, 0.0, 0.0)
    seen = Output("joint_position_rad", "position", angle, True, 0.0)
    driven = Driven("x", STEP_S, 0.0, "motor_voltage_v", u, True, (seen,), {})
    return linear_start(driven, irregular(driven.duration_s))


def test_a_start_that_runs_away_is_moved_back_or_refused() -> None:
    start = _start()
    away = {"viscous_square": -3.0}
    assert runs_away(start.box, {**start.numbers, **away}, start.states)
    assert not runs_away(start.box, start.numbers, start.states)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = fitted_from(SQUARE, away, start)
        assert fitted_from(SQUARE, {"viscous_square": -1e6}, start) is None
    assert found is not None
    assert abs(found.numbers["viscous_square"]) < 0.01  # the joint has none
    assert all(np.isfinite(one).all() for one in found.residuals.values())
