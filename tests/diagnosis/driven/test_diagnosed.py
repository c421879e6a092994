"""A recording of a driven joint, from its import to its verdict; tests/fixtures.current_joint.py simulates it."""

import json
from pathlib import Path

import numpy as np
import pytest

from stillarm.commands.recordings.diagnose_result import write_driven
from stillarm.diagnosis.diagnose import diagnose
from stillarm.diagnosis.driven.diagnosed import DrivenResult
from stillarm.diagnosis.driven.mechanisms.missing import missing_force
from stillarm.diagnosis.driven.page import sentences
from stillarm.diagnosis.driven.recording.blocks import irregular
from tests.fixtures.current_joint import GAIN, write_recording


def _diagnosed(folder: Path, coulomb: float = 0.0, offset: float = 0.0) -> DrivenResult:
    result = diagnose(write_recording(folder / "rec.mcap", coulomb, offset))
    assert isinstance(result, DrivenResult)
    return result


@pytest.mark.blind(each_run=2, group="driven joints")
def test_dry_friction_is_named_from_data_alone_with_its_size(tmp_path: Path) -> None:
    result = _diagnosed(tmp_path, coulomb=4.0)
    assert result.table["verdict"] == "named"
    first = result.table["findings"][0]
    assert first["cause"] == "joint_coulomb_friction"
    assert first["parameters"]["coulomb"]["value"] == pytest.approx(4.0, rel=0.03)
    # the unit of the current is unknown, so the gain is of what was recorded
    assert result.table["start"]["numbers"]["gain_rad_s2_per_unit"]["value"] == pytest.approx(
        GAIN / 37.0, rel=0.02
    )
    assert "dry friction" in sentences(result)[0]
    before = missing_force(result.searched.start)
    assert before is not None
    slow = before.over_velocity
    jump = np.interp(0.3, slow.at, slow.mean) - np.interp(-0.3, slow.at, slow.mean)
    assert jump < -4.0  # of the 8 that turn over at zero velocity: a smoothed acceleration shows most

    write_driven(result, tmp_path)
    assert json.loads((tmp_path / "diagnosis.json").read_text())["verdict"] == "named"
    page = (tmp_path / "report.html").read_text()
    assert "<svg" in page and "joint_coulomb_friction" in page


@pytest.mark.blind(each_run=2, group="driven joints")
def test_a_joint_without_fault_has_none(tmp_path: Path) -> None:
    result = _diagnosed(tmp_path)
    assert result.table["verdict"] == "none" and result.table["findings"] == []


@pytest.mark.blind(each_run=2, group="driven joints")
def test_a_constant_torque_is_no_friction(tmp_path: Path) -> None:
    result = _diagnosed(tmp_path, offset=2.0)
    assert result.table["findings"][0]["cause"] == "torque_offset"
    assert result.table["findings"][0]["parameters"]["offset"]["value"] == pytest.approx(2.0, rel=0.03)


def test_no_period_of_blocks_is_held_out_throughout() -> None:
    """As the blocks of every period up to ten come, some train and some are held out."""
    split = irregular(60.0)
    assert split.held.sum() * 3 == len(split.held)
    assert not split.held[0]  # the start from rest is like nothing that comes later
    for period in range(2, 8):
        for phase in range(period):
            assert not split.held[phase::period].all()
