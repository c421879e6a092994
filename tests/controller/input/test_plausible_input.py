"""The door: what is plausible passes untouched, what is not counts as missing, and both are counted."""

from math import inf, isnan, nan

import msgspec
import pytest

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.model import Arm, Model
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.input.plausible_input import MOST_CYCLE, MOST_SAMPLES, Field, PlausibleInput
from stillarm.controller.safety.table import Operator

MODEL = Model(arm=Arm(length_m=2.0))
SAMPLE = VisualSample(3, 0, 0, 4.0, 0.0, 0.0, 0.0025, captured_s=7.0)


def door() -> PlausibleInput:
    return PlausibleInput(MODEL, 2.0)


def plausible(cycle: int = 0, **changes: object) -> CycleInput:
    read = CycleInput(cycle, 1.5, 0.1, 0.2, 0.001, 0.3, True, [SAMPLE], 0.01, int(Operator.ARM))
    for name, value in changes.items():
        setattr(read, name, value)
    return read


def counted(checked: PlausibleInput) -> dict[Field, int]:
    return {field: count for field, count in zip(Field, checked.refused, strict=True) if count}


def test_plausible_values_pass_as_the_same_object() -> None:
    """And so do missing ones: a replay of them is the same to the bit."""
    checked, missing = door(), CycleInput(1)
    read = plausible()
    assert checked.admit(read).read is read
    assert door().admit(missing).read is missing
    assert counted(checked) == {}


@pytest.mark.parametrize("value", [inf, -inf, 1e308, -1e300, 2.0**40, 10**400])
@pytest.mark.parametrize(
    ("name", "field", "instead"),
    [
        ("acceleration_m_s2", Field.ACCELERATION, nan),
        ("joint_position_rad", Field.JOINT_POSITION, nan),
        ("joint_velocity_rad_s", Field.JOINT_VELOCITY, nan),
        ("reference_rad_s", Field.REFERENCE, 0.0),
        ("deflection_m", Field.DEFLECTION, nan),
    ],
)
def test_what_no_device_can_say_is_missing(name: str, field: Field, instead: float, value: float) -> None:
    checked = door()
    read = plausible(**{name: value})
    got = getattr(checked.admit(read).read, name)
    assert isnan(got) if isnan(instead) else got == instead
    assert getattr(read, name) == value, "what is recorded is what was read"
    assert counted(checked) == {field: 1}


@pytest.mark.parametrize(
    ("changes", "field", "instead"),
    [
        ({"displacement_x_px": nan}, Field.DISPLACEMENT, {"measured": False}),
        ({"displacement_x_px": 9e5}, Field.DISPLACEMENT, {"measured": False}),
        ({"variance_x_px2": inf}, Field.VARIANCE, {}),
        ({"captured_s": 1e300}, Field.CAPTURED, {"measured": True}),
        ({"frame": 2**64}, Field.FRAME, {"frame": 0}),
        ({"frame": -1}, Field.FRAME, {"frame": 0}),
        ({"started_cycle": 2**40}, Field.STARTED_CYCLE, {"started_cycle": -1}),
        ({"started_cycle": -5000}, Field.STARTED_CYCLE, {"started_cycle": -1}),
    ],
)
def test_a_sample_loses_what_it_cannot_hold(
    changes: dict[str, object], field: Field, instead: dict[str, object]
) -> None:
    checked = door()
    (got,) = checked.admit(plausible(samples=[msgspec.structs.replace(SAMPLE, **changes)])).read.samples
    assert {name: getattr(got, name) for name in instead} == instead
    assert counted(checked) == {field: 1}


def test_a_pause_or_a_number_that_goes_back_begins_anew() -> None:
    checked = door()
    said = [checked.admit(CycleInput(cycle))[1:] for cycle in (5, 6, 1006, 2007, 2007, 3)]
    assert said == [(1, False), (1, False), (1000, False), (1001, True), (1001, True), (1001, True)]
    assert counted(checked) == {Field.CYCLE: 2}


@pytest.mark.parametrize("odd", [-1, MOST_CYCLE + 1, 10**400, nan, 1e300])
def test_an_impossible_cycle_number_counts_as_the_next(odd: int) -> None:
    checked = door()
    checked.admit(CycleInput(7))
    read, elapsed, begin_anew = checked.admit(CycleInput(odd))
    assert (read.cycle, elapsed, begin_anew) == (8, 1, False)
    assert checked.admit(CycleInput(9)).elapsed == 1


def test_a_drive_that_has_reported_is_silent_when_its_age_is_odd() -> None:
    """NaN would mean a drive that never reports, which nothing watches."""
    checked = door()
    assert isnan(checked.admit(CycleInput(0)).read.joint_age_s)
    assert checked.admit(CycleInput(1, joint_age_s=0.002)).read.joint_age_s == 0.002
    assert checked.admit(CycleInput(101, joint_age_s=nan)).read.joint_age_s == pytest.approx(0.102)
    assert checked.admit(CycleInput(201, joint_age_s=-1.0)).read.joint_age_s == pytest.approx(0.202)
    assert checked.admit(CycleInput(202, joint_age_s=inf)).read.joint_age_s == 1e6


def test_of_an_odd_word_of_the_operator_the_emergency_stop_alone_is_heard() -> None:
    checked = door()
    assert checked.admit(CycleInput(0, operator=2**40 + 8 + 1)).read.operator == Operator.EMERGENCY_STOP
    assert checked.admit(CycleInput(1, operator=2**40 + 1)).read.operator == 0
    assert checked.admit(CycleInput(2, operator=nan)).read.operator == 0  # type: ignore[arg-type]


def test_of_very_many_samples_the_newest_count_and_a_restart_among_the_others_stays_known() -> None:
    many = [VisualSample(k, 0, 0, 1.0, restarted=k == 3) for k in range(60)]
    checked = door()
    got = checked.admit(CycleInput(9, samples=many)).read.samples
    assert [one.frame for one in got] == list(range(60 - MOST_SAMPLES, 60))
    assert [one.restarted for one in got] == [True] + [False] * (MOST_SAMPLES - 1)
    assert counted(checked) == {Field.SAMPLES: 60 - MOST_SAMPLES}


def test_images_that_agree_on_a_far_jump_have_another_zero() -> None:
    checked = door()
    seen = [0.0, 0.0, 900.0, 900.0, 900.0, 900.0]
    got = [
        checked.admit(CycleInput(15 * k, samples=[VisualSample(k, 15 * k, 0, px)])).read.samples[0]
        for k, px in enumerate(seen)
    ]
    assert [one.measured for one in got] == [True, True, False, False, True, True]
    assert [one.restarted for one in got] == [False, False, False, False, True, False]


def test_reports_that_agree_on_a_far_jump_begin_anew() -> None:
    checked = door()
    said = [checked.admit(CycleInput(k, joint_position_rad=0.0 if k < 10 else 0.8)) for k in range(100)]
    assert [k for k, one in enumerate(said) if one.begin_anew] == [59]
    assert all(isnan(one.read.joint_position_rad) for one in said[10:59])
