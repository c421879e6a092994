"""Recordings of one rig in one table of samples."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.common.user_error import UserError
from stillarm.diagnosis.driven.fitting.fitting import fit
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.recording.signals import Driven, Output
from stillarm.diagnosis.driven.together.joining import joined, joined_split


def recording(name: str, step_s: float, samples: int, seed: int = 0, also: str = "") -> Driven:
    generator = np.random.default_rng(seed)
    names = ["joint_position_rad", *([also] if also else [])]
    outputs = tuple(
        Output(
            one, "position" if "position" in one else "velocity", generator.normal(size=samples), True, 0.0
        )
        for one in names
    )
    u = np.repeat(generator.normal(size=samples // 20 + 1), 20)[:samples]
    return Driven(name, step_s, 0.0, "motor_current_a", u, True, outputs, {})


def test_parts_are_the_recordings_again() -> None:
    each = [recording("a", 0.01, 1000, 1), recording("b", 0.01, 800, 2)]
    both = joined(each)
    assert both.recordings == 2 and both.samples == 1800
    for k, one in enumerate(each):
        assert np.array_equal(both.part(k).u, one.u)
        assert np.array_equal(both.part(k).outputs[0].values, one.outputs[0].values)


def test_what_is_not_in_every_recording_is_left_out_and_told() -> None:
    both = joined([recording("a", 0.01, 1000, also="joint_velocity_rad_s"), recording("b", 0.01, 1000)])
    assert [one.name for one in both.outputs] == ["joint_position_rad"]
    assert both.left_out == {"joint_velocity_rad_s": "not in every recording"}


def test_the_quicker_recording_is_thinned_to_the_slowers_rate() -> None:
    both = joined([recording("a", 0.002, 2000), recording("b", 0.01, 400)])
    assert both.step_s == 0.01 and both.samples == 800


def test_what_can_be_no_one_rig_is_refused_in_one_line() -> None:
    a = recording("a", 0.01, 1000)
    with pytest.raises(UserError, match=r"b: its input is motor_voltage_v.*--apart"):
        joined([a, replace(a, name="b", drive="motor_voltage_v")])
    with pytest.raises(UserError, match=r"142\.857 Hz is no multiple of 100 Hz.*--apart"):
        joined([a, recording("b", 0.007, 1000)])
    with pytest.raises(UserError, match="no channel is in every recording"):
        joined([a, replace(a, outputs=(replace(a.outputs[0], name="strain"),))])


def test_a_joined_run_is_each_recordings_own_run() -> None:
    """With numbers that hold in one alone; nothing of a recording's input reaches the next one."""
    each = [recording("a", 0.01, 1000, 1), recording("b", 0.01, 800, 2)]
    both = joined(each)
    box = GreyBox(both, joined_split(both, (0.0, 0.0), ()))
    numbers = {"gain": 2.0, "damping": 0.5, "delay": 0.003, "lag": 0.05, "coulomb @1": 0.7}
    states = np.random.default_rng(3).normal(size=(len(box.split.held), 2))
    run = box.run(numbers, states)
    for k, coulomb in enumerate((0.0, 0.7)):
        alone = GreyBox(each[k], box.parts[k].split)
        own = {"gain": 2.0, "damping": 0.5, "delay": 0.003, "lag": 0.05, "coulomb": coulomb}
        wanted = alone.run(own, states[box.recording == k]).outputs["joint_position_rad"]
        rows = (box.recording == k)[box.block]
        assert np.array_equal(run.outputs["joint_position_rad"][rows], wanted)


def test_a_part_of_a_fit_has_its_residual_and_numbers() -> None:
    both = joined([recording("a", 0.01, 1000, 1), recording("b", 0.01, 800, 2)])
    box = GreyBox(both, joined_split(both, (0.0, 0.0), ()))
    fitted = fit(box, {"gain": 1.0, "damping": 1.0, "coulomb @1": 0.1}, ("gain", "coulomb @1"), steps=1)
    parts = [fitted.part(k) for k in range(2)]
    whole = np.concatenate([one.residuals["joint_position_rad"] for one in parts])
    assert np.array_equal(whole, fitted.residuals["joint_position_rad"])
    assert "coulomb" not in parts[0].numbers and parts[1].numbers["coulomb"] == fitted.numbers["coulomb @1"]
    assert parts[0].free == () and parts[1].free == ("coulomb",)
