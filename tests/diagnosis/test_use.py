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


def test_without_a_length_there_is_no_deflection_to_predict() -> None:
    bare = msgspec.structs.replace(MODEL, arm=msgspec.structs.replace(MODEL.arm, length_m=None))
    with pytest.raises(UserError, match="length_m"):
        worth_in_use(bare, bare, CONFIGURATION)
