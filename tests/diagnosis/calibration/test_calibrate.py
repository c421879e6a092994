"""Calibration from a model that is wrong in everything that it may be wrong in: signs, frequency, delay, drive.

Recordings come from virtual time; what is true is the model that made them.
"""

from pathlib import Path

import msgspec
import pytest

from stillarm.common.files.model import Drive, Mode, Model, Timing
from stillarm.common.files.scenario import Move, Scenario, Strike
from stillarm.common.recording.reader import open_recording
from stillarm.diagnosis.calibration.calibrate import Calibration, calibrate
from stillarm.diagnosis.data.reading import read_measured
from tests.fixtures.simulated import MODEL, record

pytestmark = pytest.mark.slow

replace = msgspec.structs.replace
TRUE = replace(MODEL, drive=Drive(bandwidth_hz=14.0, dead_time_s=0.006))
WRONG = replace(
    MODEL,
    arm=replace(MODEL.arm, modes=[Mode(4.0, 0.03, 0.8)]),
    drive=Drive(bandwidth_hz=30.0, dead_time_s=0.0),
    accelerometer=replace(MODEL.accelerometer, scale=-0.5),
    camera=replace(MODEL.camera, scale_px_per_m=-300.0),
    timing=Timing(capture_delay_s=0.02),
)
MOVES = [Move(1.5, 1.8, 0.1), Move(2.6, 2.9, -0.1), Move(4.0, 4.2, -0.12), Move(4.2, 4.4, 0.12)]


def calibrated(folder: Path, scenario: Scenario, wrong: Model = WRONG) -> Calibration:
    return calibrate(
        read_measured(open_recording(record(folder, scenario=scenario, true=TRUE)), wrong), wrong
    )


def near(found: Model, signs_and_scales: bool) -> None:
    mode, true = found.arm.modes[0], TRUE.arm.modes[0]
    assert mode.frequency_hz == pytest.approx(true.frequency_hz, rel=0.002)
    assert mode.damping_ratio == pytest.approx(true.damping_ratio, rel=0.1)
    if signs_and_scales:
        assert mode.participation == pytest.approx(true.participation, rel=0.03)
        assert found.camera.scale_px_per_m == pytest.approx(TRUE.camera.scale_px_per_m, rel=0.02)
        assert found.accelerometer.scale == pytest.approx(TRUE.accelerometer.scale, rel=0.02)
        assert found.timing.capture_delay_s == pytest.approx(TRUE.timing.capture_delay_s, abs=0.02)
        assert found.drive.bandwidth_hz == pytest.approx(14.0, rel=0.05)
        assert found.drive.dead_time_s == pytest.approx(0.006, abs=0.001)


def test_from_moves_alone(tmp_path: Path) -> None:
    near(calibrated(tmp_path, Scenario(duration_s=14.0, moves=MOVES)).model, True)


def test_from_moves_with_impacts_among_them(tmp_path: Path) -> None:
    """Nobody has told of the impacts: they are found on the way."""
    strikes = [Strike(6.5, 0.01), Strike(10.0, -0.008)]
    found = calibrated(tmp_path, Scenario(duration_s=15.0, moves=MOVES, strikes=strikes))
    near(found.model, True)
    assert [round(0.001 * cycle, 1) for cycle in found.fit.world.impacts] == [6.5, 10.0]


def test_frequency_and_damping_from_a_ring_down_alone(tmp_path: Path) -> None:
    """Without a move, signs and scales have nothing to go by, and are not claimed."""
    wrong = replace(MODEL, arm=replace(MODEL.arm, modes=[Mode(4.0, 0.03, 1.14)]))
    found = calibrated(tmp_path, Scenario(duration_s=10.0, strikes=[Strike(1.0, 0.01)]), wrong)
    near(found.model, False)
    assert "drive.bandwidth_hz" not in found.parameters
