"""Gravity behind a motor's encoder, whose gear nobody has stated: a turn of the joint is many of the motor."""

from dataclasses import replace

import pytest

from stillarm.common.causes.driven import DRIVEN_CAUSES
from stillarm.diagnosis.driven.fitting.freedom import STATED
from stillarm.diagnosis.driven.mechanisms.unknown_gear import (
    gear_is_unknown,
    gravity_behind_a_gear,
    has_geared_gravity,
)
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.search.search import tried_forms
from stillarm.diagnosis.driven.starts.start import linear_start
from stillarm.simulation.arm.torque_joint import GC, GS, RC, RN, RS, laws_of
from tests.fixtures.driven_world import driven_of
from tests.hidden_world.driven.case import make


def test_it_is_a_wave_over_the_measured_angle_in_the_place_of_a_ripples() -> None:
    gravity = {"gravity_sine": -2.0, "gravity_cosine": 0.5}
    plain, geared = laws_of(gravity), laws_of({**gravity, "gravity_cycles": 0.1})
    assert (plain[GS], plain[GC], plain[RS]) == (-2.0, 0.5, 0.0)
    assert (geared[RS], geared[RC], geared[RN]) == (-2.0, 0.5, 0.1)
    assert geared[GS] == geared[GC] == 0.0
    cause = DRIVEN_CAUSES["gravity_load"]
    stated = cause.effect_of({**gravity, "gravity_cycles": 0.1})
    assert cause.numbers_of(stated) == {**gravity, "gravity_cycles": 0.1}
    assert cause.numbers_of(cause.effect_of(gravity)) == gravity


@pytest.mark.slow
def test_gravity_behind_a_gear_of_14_is_found_with_its_period() -> None:
    """Over the motor's angle itself gravity explains nothing, and a constant torque most of it."""
    driven = driven_of(make(7009000009, "gravity_load"))
    start = linear_start(driven, irregular(driven.duration_s))
    assert gear_is_unknown(start) and len(list(gravity_behind_a_gear(start))) == 4
    assert not gear_is_unknown(replace(start, numbers={**start.numbers, STATED: 1.0}))
    best = tried_forms(start, lambda: 1e9)[0]
    assert best.form.cause == "gravity_load"
    assert best.fit.numbers["gravity_cycles"] == pytest.approx(1.0 / 14.0, rel=0.3)
    assert has_geared_gravity(best.fit) and not gear_is_unknown(best.fit)
