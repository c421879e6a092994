"""A recording of a driven joint, from its import to its verdict; an integrator of the test's own simulates it."""

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from stillarm.commands.recordings.diagnose_result import write_driven
from stillarm.diagnosis.diagnose import diagnose
from stillarm.diagnosis.driven.blocks import irregular
from stillarm.diagnosis.driven.diagnosed import DrivenResult
from stillarm.diagnosis.driven.missing import missing_force
from stillarm.diagnosis.driven.page import sentences
from stillarm.tables.description import parse_description
from stillarm.tables.importing import import_tables
from stillarm.tables.readers.read_file import read_table_file

Array = NDArray[np.float64]
STEP_S, SAMPLES, FINE = 0.005, 3000, 40
GAIN, DAMPING = 6.0, 1.5

DESCRIPTION = """
source = "log.csv"
[[tables]]
time_column = "t"
time_unit = "s"
[[tables.channels]]
column = "u"
role = "motor_current_a"
unit = "unknown"
[[tables.channels]]
column = "angle"
role = "joint_position_rad"
unit = "rad"
[[tables.channels]]
column = "rate"
role = "joint_velocity_rad_s"
unit = "rad/s"
"""


def _input() -> Array:
    generator = np.random.default_rng(5)
    t = np.arange(SAMPLES) * STEP_S
    waves = [np.sin(2.0 * np.pi * hz * t + generator.uniform(0.0, 6.28)) for hz in np.arange(0.2, 4.0, 0.35)]
    return np.asarray(np.sum(waves, axis=0))


def _moved(u: Array, coulomb: float, offset: float) -> tuple[Array, Array]:
    """theta'' = gain u - d theta' - c sign(theta') + offset, by small steps; the input is held."""
    theta, omega, h = 0.0, 0.0, STEP_S / FINE
    angle, rate = np.empty(SAMPLES), np.empty(SAMPLES)
    for k in range(SAMPLES):
        angle[k], rate[k] = theta, omega
        for _ in range(FINE):
            free = omega + h * (GAIN * u[k] - DAMPING * omega + offset)
            new = max(free - h * coulomb, 0.0) if free > 0.0 else min(free + h * coulomb, 0.0)
            theta += 0.5 * h * (omega + new)
            omega = new
    return angle, rate


def _diagnosed(folder: Path, coulomb: float = 0.0, offset: float = 0.0) -> DrivenResult:
    generator = np.random.default_rng(1)
    u = _input()
    angle, rate = _moved(u, coulomb, offset)
    angle = angle + 1e-3 * generator.standard_normal(SAMPLES)
    rate = rate + 0.01 * generator.standard_normal(SAMPLES)
    rows = np.column_stack([np.arange(SAMPLES) * STEP_S, 37.0 * u, angle, rate])
    np.savetxt(folder / "log.csv", rows, delimiter=",", header="t,u,angle,rate", comments="", fmt="%.9g")
    description = parse_description(DESCRIPTION, "description")
    import_tables(read_table_file(folder / "log.csv"), description, DESCRIPTION, folder / "rec.mcap")
    result = diagnose(folder / "rec.mcap")
    assert isinstance(result, DrivenResult)
    return result


@pytest.mark.slow
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


@pytest.mark.slow
def test_a_joint_without_fault_has_none(tmp_path: Path) -> None:
    result = _diagnosed(tmp_path)
    assert result.table["verdict"] == "none" and result.table["findings"] == []


@pytest.mark.slow
def test_a_constant_torque_is_no_friction(tmp_path: Path) -> None:
    result = _diagnosed(tmp_path, offset=2.0)
    assert result.table["findings"][0]["cause"] == "torque_offset"
    assert result.table["findings"][0]["parameters"]["offset"]["value"] == pytest.approx(2.0, rel=0.03)


def test_no_period_of_blocks_is_held_out_throughout() -> None:
    """As the blocks of every period up to ten come, some train and some are held out."""
    split = irregular(60.0)
    assert split.held.sum() * 3 == len(split.held)
    for period in range(2, 8):
        for phase in range(period):
            assert not split.held[phase::period].all()
