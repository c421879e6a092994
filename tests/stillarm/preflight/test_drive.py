"""Whether a drive's largest input turns the joint as the model says; what a drive answers is in
test_seeded_mistakes.py."""

from pathlib import Path

import msgspec
import pytest
from msgspec.structs import replace

from stillarm.common.files.model import load_model
from stillarm.preflight.drive import judge_torque
from stillarm.preflight.verdict import Level

CONFIGS = Path(__file__).parents[3] / "configs"
TORQUE = load_model(CONFIGS / "model_torque.toml")
"""8 kg m^2, at 5 rad/s^2; 2 N m s at 0.6 rad/s, and 0.3 N m."""


@pytest.mark.parametrize(
    ("limit", "level", "says"),
    [
        (60.0, Level.OK, "60 gives 60 N m of 41.5 that"),
        (41.6, Level.OK, "of 41.5"),
        (
            21.5,
            Level.WARN,
            "needs 41.5: raise it as far as the drive allows, or drive.max_acceleration_rad_s2 = 2.5",
        ),
        (1.4, Level.FAIL, "friction at 0.6 rad/s alone takes 1.5 N m"),
        (
            msgspec.UNSET,
            Level.FAIL,
            "rig.toml: drive.input_limit: needed where the velocity loop commands the joint, and absent",
        ),
    ],
)
def test_the_largest_input_gives_the_torque_that_the_model_needs(
    limit: float | msgspec.UnsetType, level: Level, says: str
) -> None:
    (found,) = judge_torque(replace(TORQUE, drive=replace(TORQUE.drive, input_limit=limit)), "rig.toml")
    assert found.level is level and says in found.text


def test_a_current_is_worth_its_torque() -> None:
    drive = replace(TORQUE.drive, kind="current", torque_per_input=-0.5, input_limit=60.0)
    (found,) = judge_torque(replace(TORQUE, drive=drive), "rig.toml")
    assert found.level is Level.WARN and "gives 30 N m" in found.text


def test_a_joint_that_no_loop_commands_is_told() -> None:
    (found,) = judge_torque(replace(TORQUE, drive=replace(TORQUE.drive, kind="position")), "rig.toml")
    assert found.level is Level.FAIL and 'kind = "position"' in found.text


def test_a_joint_that_follows_velocities_needs_none() -> None:
    assert judge_torque(load_model(CONFIGS / "model.toml"), "rig.toml") == []
