"""Every declaration of a driven joint's cause says all there is to say, in the form that its readers rely on."""

import pytest

from stillarm.common.causes import CAUSES
from stillarm.common.causes.driven import (
    DRIVEN_CAUSES,
    DrivenCause,
    amplifier_dead_zone,
    channel_delay,
    encoder_offset,
    encoder_quantisation,
    gravity_load,
    inertia_change,
    joint_coulomb_friction,
    joint_stribeck_friction,
    joint_viscous_friction,
    sensor_lag,
    sensor_scale,
    torque_offset,
    torque_ripple,
)

FILES = (
    amplifier_dead_zone,
    channel_delay,
    encoder_offset,
    encoder_quantisation,
    gravity_load,
    inertia_change,
    joint_coulomb_friction,
    joint_stribeck_friction,
    joint_viscous_friction,
    sensor_lag,
    sensor_scale,
    torque_offset,
    torque_ripple,
)
CONTRACT = {
    "joint_coulomb_friction", "joint_viscous_friction", "joint_stribeck_friction", "torque_ripple", "torque_offset",
    "amplifier_dead_zone", "inertia_change", "encoder_offset", "encoder_quantisation", "sensor_scale", "channel_delay",
}  # fmt: skip


def test_the_contracts_causes_are_there_and_none_has_two_declarations() -> None:
    assert set(DRIVEN_CAUSES) >= CONTRACT
    assert not set(DRIVEN_CAUSES) & set(CAUSES)


def test_each_file_declares_the_cause_of_its_name() -> None:
    assert {module.__name__.rsplit(".", 1)[1]: module.CAUSE for module in FILES} == DRIVEN_CAUSES


@pytest.mark.parametrize("cause", DRIVEN_CAUSES.values(), ids=lambda cause: cause.identifier)
def test_the_words_fit_into_the_sentences_that_take_them_up(cause: DrivenCause) -> None:
    assert DRIVEN_CAUSES[cause.identifier] is cause
    for words in (cause.name, cause.sees):
        assert words[0].islower() and not words.endswith("."), words
    assert cause.provoke.endswith(".") and cause.parameters
    for other in cause.confused_with:
        assert other in DRIVEN_CAUSES and cause.identifier not in DRIVEN_CAUSES[other].confused_with
