"""The joint's motion across cycles that never came: stepped through, or passed at once, to the same end."""

import pytest

from stillarm.common.files.model import Arm, Drive, Mode, Model
from stillarm.controller.joint.drive_model import DriveModel
from stillarm.controller.joint.joint_motion import JointMotion
from stillarm.controller.joint.modal_response import ModalResponse

MODEL = Model(arm=Arm(length_m=2.0, modes=[Mode(damping_ratio=0.01)]))
NO_REPORT = float("nan")


@pytest.mark.parametrize("cycles", [2, 299, 300, 301, 700, 1000])
def test_a_pause_ends_where_its_cycles_one_by_one_would(cycles: int) -> None:
    """Under the command sent last, on which the drive goes on until its limit of position."""
    one_by_one, at_once = JointMotion(MODEL, 2.0), JointMotion(MODEL, 2.0)
    for joint in (one_by_one, at_once):
        for cycle in range(50):
            joint.begin_cycle(cycle, NO_REPORT)
            joint.send(0.3)
    for cycle in range(50, 50 + cycles):
        one_by_one.begin_cycle(cycle, NO_REPORT)
    at_once.begin_cycle(49 + cycles, NO_REPORT)
    assert at_once.position_rad == pytest.approx(one_by_one.position_rad, abs=1e-9)
    assert at_once.velocity_rad_s == pytest.approx(one_by_one.velocity_rad_s, abs=1e-9)
    assert at_once.forced_deflection_m == pytest.approx(one_by_one.forced_deflection_m, abs=1e-9)
    assert at_once.forced_rate_m_s == pytest.approx(one_by_one.forced_rate_m_s, abs=1e-8)


def test_a_drive_still_under_way_arrives_by_its_lag_and_stops_at_its_limit() -> None:
    drive = Drive(bandwidth_hz=0.5, dead_time_s=0.0)
    stepped, jumped = DriveModel(drive, 0.001), DriveModel(drive, 0.001)
    for _ in range(400):
        stepped.advance(0.2)
    jumped.advance_many(400, 0.2)
    assert jumped.velocity_rad_s == pytest.approx(stepped.velocity_rad_s, rel=0.01)
    assert jumped.position_rad == pytest.approx(stepped.position_rad, rel=0.01)
    jumped.advance_many(10**6, 0.2)
    assert (jumped.position_rad, jumped.velocity_rad_s) == (1.0, 0.0)


def test_a_mode_rings_on_under_a_constant_load() -> None:
    one_by_one, at_once = (ModalResponse(Mode(damping_ratio=0.01), 2.0, 0.001) for _ in range(2))
    for response in (one_by_one, at_once):
        response.advance(5.0)
    for _ in range(777):
        one_by_one.advance(0.3)
    at_once.advance_many(777, 0.3)
    assert at_once.deflection_m == pytest.approx(one_by_one.deflection_m, abs=1e-12)
    assert at_once.rate_m_s == pytest.approx(one_by_one.rate_m_s, abs=1e-11)
