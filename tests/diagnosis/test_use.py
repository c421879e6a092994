"""What an extended model is worth to the controller: the right model predicts better while the joint moves."""

import msgspec
import pytest

from common.configuration import load_configuration
from common.user_error import UserError
from diagnosis.use import worth_in_use
from simulation.simulated_recording import default_simulation_configuration
from tests.diagnosis.simulated import MODEL, effect

CONFIGURATION = load_configuration(default_simulation_configuration())


def test_a_late_drive_that_is_known_of_disturbs_no_prediction() -> None:
    late = msgspec.structs.replace(MODEL, effects=[effect("drive_dead_time")])
    found = worth_in_use(MODEL, late, CONFIGURATION)
    before, after = found["before"], found["after"]
    assert after["prediction_error_moving_rms"] < 0.2 * before["prediction_error_moving_rms"]
    assert after["prediction_error_free_rms"] < 0.01
    assert after["residual_vibration_rms"] < 0.05
    assert found["note"] is None


def test_a_play_that_is_known_of_is_crossed_in_time() -> None:
    """Unknown, it swallows all that the damping does: what is left is what an undamped arm would have."""
    loose = msgspec.structs.replace(MODEL, effects=[effect("gear_backlash")])
    runs = [worth_in_use(MODEL, loose, CONFIGURATION, seed) for seed in (1, 2)]
    left = [
        (found["before"]["residual_vibration_rms"], found["after"]["residual_vibration_rms"])
        for found in runs
    ]
    assert all(after < 0.1 * before for before, after in left)
    assert all(found["after"]["prediction_error_moving_rms"] < 0.01 for found in runs)
    assert runs[0]["note"] is None


@pytest.mark.parametrize(
    "cause", ["drive_lag", "accelerometer_lag", "second_bending_mode", "stale_frame_buffer"]
)
def test_what_is_known_of_a_late_or_richer_rig_does_no_harm(cause: str) -> None:
    """Predictions get better, or stay as they were; damping stays within what two runs differ by, or gets better."""
    known = msgspec.structs.replace(MODEL, effects=[effect(cause)])
    found = worth_in_use(MODEL, known, CONFIGURATION)
    before, after = found["before"], found["after"]
    if cause != "stale_frame_buffer":  # which the estimator sees by itself
        assert after["prediction_error_moving_rms"] < 0.3 * before["prediction_error_moving_rms"]
    assert after["prediction_error_free_rms"] <= before["prediction_error_free_rms"] + 1e-3
    assert after["residual_vibration_rms"] <= before["residual_vibration_rms"] + 0.002


def test_without_a_length_there_is_no_deflection_to_predict() -> None:
    bare = msgspec.structs.replace(MODEL, arm=msgspec.structs.replace(MODEL.arm, length_m=None))
    with pytest.raises(UserError, match="length_m"):
        worth_in_use(bare, bare, CONFIGURATION)
