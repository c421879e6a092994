"""Play that a world of its own hides: contacts that give way, where the diagnosis has inelastic impacts."""

from itertools import chain, repeat

import numpy as np
import pytest

from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.mechanisms.mechanisms import FORMS, Form
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven, Output
from stillarm.diagnosis.driven.search.judging import CONVINCES, Tried
from stillarm.diagnosis.driven.search.search import plainer_first, search, tried_forms
from stillarm.diagnosis.driven.starts.start import linear_start
from tests.fixtures.current_joint import STEP_S, drive_input, moved
from tests.fixtures.driven_world import driven_of
from tests.hidden_world.driven.case import make


@pytest.mark.slow
@pytest.mark.parametrize("seed", [424200012, 424200024])
def test_play_is_found_with_its_gap_with_and_without_a_mode(seed: int) -> None:
    """Behind a motor's encoder and a bending arm; between a link's encoder and a motor's velocity."""
    case = make(seed, "gear_backlash")
    assert case.effect is not None
    driven = driven_of(case)
    start = linear_start(driven, irregular(driven.duration_s))
    best = tried_forms(start, lambda: 1e9)[0]
    assert best.form.cause == "gear_backlash" and best.merit > CONVINCES
    # an angle of the motor is before the gear, whose ratio the diagnosis does not know
    ratio = case.rig.drive.gear_ratio if any(one.kind == "motor" for one in driven.outputs) else 1.0
    assert best.fit.numbers["gap"] == pytest.approx(ratio * case.effect.size, rel=0.25)


@pytest.mark.slow
def test_a_bending_alone_asks_for_the_joints_damping_and_no_further_mode() -> None:
    """Nothing is hidden; the joint's damping is a pole of its own, for which two further modes stood before."""
    driven = driven_of(make(7009500016, "none"))
    best = tried_forms(linear_start(driven, irregular(driven.duration_s)), lambda: 1e9)[0]
    assert (best.form.cause, best.form.words) == ("", "a damping of the joint") and best.merit > 100.0


@pytest.mark.slow
def test_a_round_that_the_time_did_not_suffice_for_is_told() -> None:
    """The joint rubs. An answer without a cause, as none could be tried, must not pass for one that has tried all."""
    u = drive_input()
    angle, _ = moved(u, 4.0, 0.0)
    seen = Output("joint_position_rad", "position", np.asarray(angle), True, 0.0)
    driven = Driven("x", STEP_S, 0.0, "motor_voltage_v", u, True, (seen,), {})
    left = chain([10.0, 10.0], repeat(-1.0))
    found = search(driven, irregular(driven.duration_s), lambda done, what: None, lambda: next(left))
    assert found.rounds == () and found.left_out == ("some forms of causes",)


def test_gravity_gives_way_to_a_constant_torque_that_does_as_well() -> None:
    """On a joint that turns little, gravity is one, and its second number makes up for anything small."""
    u = drive_input()
    angle, _ = moved(u, 0.0, 0.0)
    seen = Output("joint_position_rad", "position", np.asarray(angle), True, 0.0)
    driven = Driven("x", STEP_S, 0.0, "motor_voltage_v", u, True, (seen,), {})
    fitted = linear_start(driven, irregular(driven.duration_s))
    gravity, offset, dead = (
        next(one for one in FORMS if one.cause == cause)
        for cause in ("gravity_load", "torque_offset", "amplifier_dead_zone")
    )

    def first(*tried: tuple[Form, float]) -> str:
        return plainer_first([Tried(form, fitted, merit, merit) for form, merit in tried])[0].form.cause

    assert first((gravity, 60.0), (offset, 60.0 - CONVINCES + 1.0)) == "torque_offset"
    assert first((gravity, 60.0), (offset, 60.0 - CONVINCES - 1.0)) == "gravity_load"
    assert first((gravity, 60.0), (dead, 59.0)) == "gravity_load"


def test_blocks_of_a_velocity_alone_begin_where_the_joint_has_turned_to() -> None:
    """So that what repeats over the angle has one phase in all of them."""
    time = np.arange(3000) * STEP_S
    seen = Output("joint_velocity_rad_s", "velocity", 0.5 + np.sin(time), True, 0.0)
    driven = Driven("x", STEP_S, 0.0, "motor_voltage_v", np.cos(time), True, (seen,), {})
    box = GreyBox(driven, irregular(driven.duration_s))
    begun = box.first_states({})[:, 0]
    at = time[box.starts[:-1]]
    assert begun == pytest.approx(0.5 * at + 1.0 - np.cos(at), abs=0.01)
