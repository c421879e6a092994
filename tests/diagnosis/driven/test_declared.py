"""extended.toml of a driven joint: it declares what was found, and a diagnosis with it finds nothing more."""

from pathlib import Path

import numpy as np
import pytest

from stillarm.common.causes.driven import DRIVEN_CAUSES
from stillarm.common.files.model import Drive, Model, check_model, load_model
from stillarm.common.files.scenario import Scenario
from stillarm.common.user_error import UserError
from stillarm.diagnosis.diagnose import diagnose
from stillarm.diagnosis.driven.declared import declared_numbers
from stillarm.diagnosis.driven.diagnosed import DrivenResult
from stillarm.diagnosis.driven.recording.signals import Driven, Output
from stillarm.diagnosis.report.extended_model import model_text
from tests.fixtures.current_joint import write_recording
from tests.fixtures.simulated import record

POSITION = Output("joint_position_rad", "position", np.zeros(3), True, 0.0)
DRIVEN = Driven("x", 0.001, 0.0, "joint_torque_n_m", np.zeros(3), False, (POSITION,), {})

NUMBERS = {
    "amplifier_dead_zone": {"dead_zone": 0.2},
    "channel_delay": {"delay joint_velocity_rad_s": 0.01},
    "encoder_offset": {"offset joint_velocity_rad_s": -0.3},
    "encoder_quantisation": {"step joint_velocity_rad_s": 0.02},
    "gravity_load": {"gravity_sine": -2.0, "gravity_cosine": 0.5},
    "inertia_change": {"inertia_excess": -0.2},
    "joint_coulomb_friction": {"coulomb": 3.0, "coulomb_difference": -0.5},
    "joint_stribeck_friction": {"coulomb": 3.0, "stribeck": 1.0, "log_stribeck_velocity": -2.0},
    "joint_viscous_friction": {"viscous_square": -0.4},
    "sensor_lag": {"lag joint_velocity_rad_s": 0.03},
    "sensor_scale": {"scale joint_velocity_rad_s": 1.05},
    "torque_offset": {"offset": -0.7},
    "torque_ripple": {"ripple_sine": 0.1, "ripple_cosine": -0.2, "ripple_cycles": 24.0},
}


@pytest.mark.parametrize("cause", DRIVEN_CAUSES)
def test_what_is_written_is_what_is_read(cause: str, tmp_path: Path) -> None:
    numbers = NUMBERS[cause]
    channel = "joint_velocity_rad_s" if any(" " in name for name in numbers) else ""
    effect = DRIVEN_CAUSES[cause].effect_of(numbers, channel)
    file = tmp_path / "extended.toml"
    file.write_text(model_text(Model(effects=[effect])))
    read = declared_numbers(load_model(file), DRIVEN)
    assert read == pytest.approx(numbers)


def test_a_limit_is_taken_in_the_recordings_own_unit() -> None:
    assert declared_numbers(Model(drive=Drive(input_limit=2.0)), DRIVEN) == {"limit": 2.0}
    stated = Drive(kind="torque", inertia_kg_m2=1.0, input_limit=2.0)
    assert declared_numbers(Model(drive=stated), DRIVEN) == {}


@pytest.mark.parametrize(
    "effect, said",
    [
        ({"cause": "joint_coulomb_friction"}, r"coulomb_rad_s2: needed by joint_coulomb_friction"),
        (
            {"cause": "torque_offset", "offset": 1.0},
            r"torque_offset has no such parameter; it takes offset_rad_s2",
        ),
        (
            {"cause": "sensor_lag", "lag_s": 0.1, "channel": "nose"},
            r'channel = .nose.: "joint_position_rad" or',
        ),
        ({"cause": "joint_coulomb"}, r"no such cause; the nearest is 'joint_coulomb_friction'"),
    ],
)
def test_a_wrong_effect_is_refused_in_one_line(effect: dict[str, float | str], said: str) -> None:
    with pytest.raises(UserError, match=said) as told:
        check_model(Model(effects=[effect]), "m.toml")
    assert "\n" not in str(told.value)


@pytest.mark.blind(each_run=1, group="a recording of what its model declares")
def test_with_its_extended_model_a_recording_has_nothing_more(tmp_path: Path) -> None:
    path = write_recording(tmp_path / "rec.mcap", coulomb=4.0)
    first = diagnose(path)
    assert isinstance(first, DrivenResult) and first.table["verdict"] == "named"
    (tmp_path / "extended.toml").write_text(model_text(first.extended))
    extended = load_model(tmp_path / "extended.toml")
    assert extended.effects[0]["cause"] == "joint_coulomb_friction"
    assert extended.effects[0]["coulomb_rad_s2"] == pytest.approx(4.0, rel=0.03)
    again = diagnose(path, extended)
    assert again.table["verdict"] == "none" and again.table["findings"] == []
    # the same model on a rig that rubs more: the declaration is what is wrong
    more = diagnose(write_recording(tmp_path / "more.mcap", coulomb=6.0), extended)
    assert more.table["findings"][0]["cause"] == "joint_coulomb_friction"
    assert more.table["findings"][0]["parameters"]["coulomb"]["value"] == pytest.approx(6.0, rel=0.03)


@pytest.mark.slow
def test_a_model_of_a_driven_joints_cause_is_refused_elsewhere(tmp_path: Path) -> None:
    model = Model(effects=[{"cause": "torque_offset", "offset_rad_s2": 1.0}])
    with pytest.raises(UserError, match="only `stillarm diagnose` of such a recording obeys"):
        diagnose(record(tmp_path, scenario=Scenario(duration_s=2.0)), model)
