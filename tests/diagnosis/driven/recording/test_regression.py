"""The joint's measured motion in the units of a fit: a motor's encoder turns by the gear's ratio more."""

import numpy as np
import pytest

from stillarm.diagnosis.driven.recording.regression import joint_motion, regressed_joint
from stillarm.diagnosis.driven.recording.signals import Driven, Output
from tests.fixtures.current_joint import STEP_S, drive_input, moved

RATIO, NAME = 50.0, "motor_position_rad"


def _driven(ratio: float) -> Driven:
    u = drive_input()
    angle, _ = moved(u, 4.0, 0.0)
    seen = Output(NAME, "motor", ratio * np.asarray(angle), True, 0.0)
    return Driven("x", STEP_S, 0.0, "motor_voltage_v", u, True, (seen,), {})


def test_a_motors_angle_is_told_as_the_joints_where_the_gear_is_stated() -> None:
    joint, motor = joint_motion(_driven(1.0)), joint_motion(_driven(RATIO), numbers={f"scale {NAME}": RATIO})
    assert joint is not None and motor is not None
    for one, other in zip(joint, motor, strict=True):
        assert other == pytest.approx(one, abs=1e-9)
    as_measured = joint_motion(_driven(RATIO))
    assert as_measured is not None
    assert float(np.ptp(as_measured[0])) == pytest.approx(RATIO * float(np.ptp(joint[0])))


def test_friction_behind_a_stated_gear_is_that_of_the_joint() -> None:
    joint = regressed_joint(_driven(1.0))
    assert joint is not None
    found = regressed_joint(_driven(RATIO), numbers={f"scale {NAME}": RATIO})
    assert found == pytest.approx(joint)
