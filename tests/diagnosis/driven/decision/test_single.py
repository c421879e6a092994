"""One cause in place of two where it can be: friction by direction, unless a constant torque is beyond all friction."""

import numpy as np
import pytest

from stillarm.diagnosis.driven.decision.single import one_for_two
from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, fit
from stillarm.diagnosis.driven.mechanisms.mechanisms import FORMS
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven, Output
from stillarm.diagnosis.driven.search.judging import Tried
from stillarm.diagnosis.driven.search.removal import without_form
from stillarm.diagnosis.driven.search.search import Round, Searched
from stillarm.diagnosis.driven.starts.start import linear_start
from tests.fixtures.current_joint import SAMPLES, STEP_S, drive_input, moved

PLAIN = next(one for one in FORMS if one.numbers == ("coulomb",))
OFFSET = next(one for one in FORMS if one.numbers == ("offset",))


def _searched(coulomb: float, offset: float) -> Searched:
    """A search that has ended with plain friction and a constant torque."""
    u = drive_input()
    angle, _ = moved(u, coulomb, offset)
    angle = angle + 1e-3 * np.random.default_rng(7).standard_normal(SAMPLES)
    seen = Output("joint_position_rad", "position", angle, True, 0.0)
    driven = Driven("x", STEP_S, 0.0, "motor_voltage_v", u, True, (seen,), {})
    start = linear_start(driven, irregular(driven.duration_s))
    rubs = _with(start, coulomb=coulomb)
    final = _with(rubs, offset=offset)
    rounds = ((start, PLAIN, rubs), (rubs, OFFSET, final))
    taken = tuple(Round(before, (Tried(form, after, 99.0, 99.0),)) for before, form, after in rounds)
    return Searched(start, taken, final, (), ())


def _with(fitted: DrivenFit, **numbers: float) -> DrivenFit:
    return fit(fitted.box, {**fitted.numbers, **numbers}, (*fitted.free, *numbers), fitted.states)


@pytest.mark.slow
def test_friction_that_is_larger_one_way_is_one_cause() -> None:
    """4 both ways and 3 that pushes on are 1 one way and 7 the other: the same equation."""
    found = one_for_two(_searched(4.0, 3.0))
    (only,) = found.rounds
    assert only.taken.form.cause == "joint_coulomb_friction" and only.taken.form.words == "by direction"
    assert found.final.numbers["coulomb"] == pytest.approx(4.0, rel=0.03)
    assert found.final.numbers["coulomb_difference"] == pytest.approx(-3.0, rel=0.03)
    assert "offset" not in found.final.free


@pytest.mark.slow
def test_what_would_not_be_told_beside_friction_asks_for_no_fuller_form() -> None:
    two = _searched(4.0, 0.0)
    assert one_for_two(two) is two


@pytest.mark.slow
def test_a_torque_beyond_all_friction_stays_a_cause_of_its_own() -> None:
    two = _searched(1.5, 4.0)
    assert one_for_two(two) is two


@pytest.mark.slow
def test_what_is_taken_out_of_a_model_is_out_of_it() -> None:
    found = _searched(1.5, 4.0)
    without = without_form(found.final, OFFSET, [PLAIN, OFFSET], found.start.numbers)
    assert "offset" not in without.free and "offset" not in without.numbers
    assert "coulomb" in without.free
    assert float(without.whole.sum()) < float(found.final.whole.sum()) - 100.0
