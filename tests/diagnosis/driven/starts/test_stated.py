"""What a model file says of a driven joint."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from stillarm.common.files.model import Arm, Drive, Mode, Model, check_model
from stillarm.common.user_error import UserError
from stillarm.diagnosis.driven.greybox.laws import carried_by
from stillarm.diagnosis.driven.recording.signals import Driven, Output
from stillarm.diagnosis.driven.starts.stated import stated_by

POSITION = Output("joint_position_rad", "position", np.zeros(3), True, 0.0)
DRIVEN = Driven("x", 0.001, 0.0, "joint_torque_n_m", np.zeros(3), True, (POSITION,), {})
DRIVE = Drive(kind="torque", inertia_kg_m2=0.5, viscous_n_m_s=0.2)
MODE = Mode(frequency_hz=3.0, damping_ratio=0.01, participation=1.1, modal_mass_kg=0.2)


def test_the_hub_has_what_the_modes_do_not_carry() -> None:
    found = stated_by(Model(arm=Arm(length_m=1.0, modes=[MODE]), drive=DRIVE), DRIVEN, "m")
    assert found is not None and found.modes == 1
    carried = 0.2 * 1.1**2
    assert found.numbers["gain"] == pytest.approx(1.0 / (0.5 - carried))
    assert found.numbers["carries_1"] == pytest.approx(carried / (0.5 - carried))
    assert set(found.fixed) == {"gain", "damping", "carries_1", "scale joint_position_rad"}


def test_a_raw_input_leaves_the_gain_open() -> None:
    found = stated_by(Model(drive=DRIVE), _raw(), "m")
    assert found is not None and "gain" not in found.numbers and "gain" not in found.fixed


def _raw() -> Driven:
    return Driven("x", 0.001, 0.0, "joint_torque_n_m", np.zeros(3), False, (POSITION,), {})


def test_modes_that_carry_more_than_all_are_refused_in_one_line() -> None:
    heavy = msgspec.structs.replace(MODE, modal_mass_kg=5.0)
    with pytest.raises(UserError, match=r"inertia_kg_m2 = 0\.5: the modes alone carry"):
        stated_by(Model(arm=Arm(length_m=1.0, modes=[heavy]), drive=DRIVE), DRIVEN, "m")
    with pytest.raises(UserError, match="length_m"):
        stated_by(Model(arm=Arm(modes=[MODE]), drive=DRIVE), DRIVEN, "m")


def test_a_driven_joint_without_inertia_is_refused_and_a_velocity_joint_states_none() -> None:
    with pytest.raises(UserError, match="inertia_kg_m2: needed where"):
        check_model(Model(drive=Drive(kind="current")), "m")
    assert stated_by(Model(), DRIVEN, "m") is None


def test_a_mode_that_follows_less_than_stated_carries_less() -> None:
    """m (participation length)^2 over the hub's inertia; a bending of unknown unit says nothing of it."""
    bending = Output("deflection_m", "deflection", np.zeros(3), True, 0.0)
    for known in (True, False):
        sensors = (POSITION, replace(bending, stated=known))
        model = Model(arm=Arm(length_m=1.0, modes=[MODE]), drive=DRIVE)
        found = stated_by(model, replace(DRIVEN, outputs=sensors), "m")
        assert found is not None
        less = {**found.numbers, "follows_1": 0.5 * found.numbers["follows_1"]}
        assert carried_by(less, 1) == pytest.approx((0.25 if known else 1.0) * found.numbers["carries_1"])


def test_an_accelerometer_of_known_unit_sees_the_tip_in_its_own_size() -> None:
    tip = Output("acceleration_m_s2", "acceleration", np.zeros(3), True, 0.0)
    model = Model(arm=Arm(length_m=0.7, modes=[MODE]), drive=DRIVE)
    found = stated_by(model, replace(DRIVEN, outputs=(POSITION, tip)), "m")
    assert found is not None and found.numbers["direct acceleration_m_s2"] == 0.7
    assert {"direct acceleration_m_s2", "share_1 acceleration_m_s2"} <= set(found.fixed)
