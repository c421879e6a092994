"""The second hidden world beside the program: its bundles come in without complaint, and both move a plain arm
alike."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stillarm.common.csv_bundle.bundle_import import import_bundle
from stillarm.common.files.model import Drive
from stillarm.common.recording.reader import open_recording
from stillarm.simulation.arm.free_run import free_run
from stillarm.simulation.arm.state import LAW, make_arm
from tests.hidden_world.rigs.bundle import write_bundle
from tests.hidden_world.rigs.case import make
from tests.hidden_world.rigs.draw import draw_rig
from tests.hidden_world.rigs.motion import move
from tests.hidden_world.rigs.moves import TIP, draw_moves
from tests.hidden_world.rigs.rig import FINE, TICK_S

pytestmark = pytest.mark.slow


@pytest.mark.blind(each_run=3, seed=(1, 2, 3))
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("what", ["none", "clock_step", "stop_contact"])
def test_a_bundle_comes_in_without_complaint(what: str, seed: int, tmp_path: Path) -> None:
    case = make(seed, what)
    write_bundle(case, tmp_path / "bundle")
    report = import_bundle(tmp_path / "bundle", tmp_path / "recording.mcap")
    assert report.fast_rows == case.rig.cycles and report.frame_rows == len(case.recording.images.index)
    assert not report.unknown and report.model_given
    stepped_back = what == "clock_step" and case.effects[0].sign < 0
    assert all(stepped_back and "steps back" in note for note in report.notes)
    assert open_recording(tmp_path / "recording.mcap").counts


@pytest.mark.parametrize("seed", [1, 4, 9, 10])
def test_the_plain_arm_moves_as_the_program_moves_it(seed: int) -> None:
    """Conventions agree: when a command takes hold, what a sensor reads at a jump, the drive's lag and its limit."""
    rig = replace(draw_rig(seed), swinging_m=0.0)
    moves = [m for m in draw_moves(rig) if m.kind not in TIP]
    mine = move(rig, moves, (), nuisance=False)
    drive = Drive(
        rig.drive.bandwidth_hz,
        rig.drive.dead_time_s,
        rig.drive.max_velocity_rad_s,
        rig.drive.max_acceleration_rad_s2,
        -3.0,
        3.0,
    )
    modes = np.array([[m.frequency_hz, m.damping_ratio, m.participation * rig.length_m] for m in rig.modes])
    arm, whole = make_arm(drive, TICK_S, modes, np.zeros(0, LAW))
    n, k = rig.cycles, len(modes)
    joint, motor, q, bend = np.zeros((n, 4)), np.zeros((n, 2)), np.zeros((n, k)), np.zeros((n, k))
    no_jumps = np.zeros(0, np.int64), np.zeros((0, k, 2))
    free_run(arm, mine.asked, whole, *no_jumps, joint, motor, q, bend)
    for theirs, ours in (
        (rig.length_m * joint[:, 0] + q.sum(axis=1), mine.s_m),
        (rig.length_m * joint[:, 2] + bend.sum(axis=1), mine.tip_m_s2),
    ):
        assert np.max(np.abs(theirs - ours[::FINE][:n])) < 1e-5 * np.max(np.abs(theirs))
