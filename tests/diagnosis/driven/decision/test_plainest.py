"""Of forms that hold one another, one is told."""

import numpy as np

from stillarm.diagnosis.driven.decision.plainest import plainest
from stillarm.diagnosis.driven.mechanisms.mechanisms import FORMS, Form
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven, Output
from stillarm.diagnosis.driven.search.judging import Tried
from stillarm.diagnosis.driven.search.search import Round, Searched
from stillarm.diagnosis.driven.starts.start import linear_start
from tests.fixtures.current_joint import STEP_S, drive_input, moved


def _form(cause: str, words: str) -> Form:
    return next(one for one in FORMS if (one.cause, one.words) == (cause, words))


def test_a_cause_that_was_taken_twice_is_told_once() -> None:
    """Friction, and then the same with another number: neither would be worth anything beside the other."""
    u = drive_input()
    angle, _ = moved(u, 0.0, 0.0)
    seen = Output("joint_position_rad", "position", np.asarray(angle), True, 0.0)
    driven = Driven("x", STEP_S, 0.0, "motor_voltage_v", u, True, (seen,), {})
    fitted = linear_start(driven, irregular(driven.duration_s))
    plain = _form("joint_coulomb_friction", "the same both ways")
    fuller = _form("joint_coulomb_friction", "by direction")
    offset = _form("torque_offset", "constant")
    rounds = tuple(Round(fitted, (Tried(one, fitted, 50.0, 50.0),)) for one in (plain, offset, fuller))
    told = plainest(Searched(fitted, rounds, fitted, (), ()))
    assert [one.taken.form for one in told.rounds] == [plain, offset]
