"""A driven joint as a model file states it."""

import pytest

from stillarm.common.files.driven_joint import commanded_joint, driven_joint
from stillarm.common.files.model import Arm, Drive, Model
from stillarm.common.user_error import UserError
from tests.fixtures.torque_model import FIRST, torque_model


def test_the_hub_is_what_the_modes_do_not_carry() -> None:
    joint = driven_joint(
        torque_model(FIRST, torque_per_input=0.5, back_emf_n_m_s=0.2, viscous_n_m_s=0.1), "m"
    )
    assert joint is not None
    assert joint.hub_inertia_kg_m2 == pytest.approx(12.0 - 1.5 * (1.14 * 2.0) ** 2)
    assert joint.torque_per_input == 0.5
    assert joint.damping_n_m_s == pytest.approx(0.3)
    assert joint.limit == 1e4


def test_a_joint_that_follows_velocities_is_no_driven_one() -> None:
    assert driven_joint(Model(), "m") is None


def test_a_mode_without_a_mass_carries_nothing() -> None:
    joint = driven_joint(Model(drive=Drive(kind="torque", inertia_kg_m2=12.0)), "m")
    assert joint is not None and joint.carried_kg_m2 == (0.0,)
    assert joint.hub_inertia_kg_m2 == 12.0
    assert joint.limit is None


@pytest.mark.parametrize(
    ("model", "said"),
    [
        (torque_model(inertia_kg_m2=1.0), r"m\.toml: drive\.inertia_kg_m2 = 1: the modes alone carry"),
        (
            Model(arm=Arm(modes=[FIRST]), drive=Drive(kind="torque", inertia_kg_m2=12.0)),
            r"m\.toml: arm\.length_m",
        ),
        (torque_model(torque_per_input=0.0), r"m\.toml: drive\.torque_per_input = 0"),
        (torque_model(kind="position"), r'm\.toml: drive\.kind = "position": only `stillarm diagnose`'),
    ],
)
def test_a_joint_that_no_rig_can_have_or_no_loop_can_drive_is_refused(model: Model, said: str) -> None:
    with pytest.raises(UserError, match=said):
        commanded_joint(model, "m.toml")
