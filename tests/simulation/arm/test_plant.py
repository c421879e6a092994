"""The plant against an independent solution of its equations by scipy at rtol 1e-10."""

from math import pi

import numpy as np
import pytest

from stillarm.common.files.beam import tip_slopes_per_m
from stillarm.common.files.model import Arm, Drive, Mode, Model
from stillarm.common.user_error import UserError
from stillarm.simulation.arm.plant import Plant
from tests.reference.plant_judge import (
    CYCLE_S,
    FAST,
    FIRST,
    LENGTH_M,
    SECOND,
    assert_same,
    model,
    moves,
    run,
    solved,
)


@pytest.mark.slow
@pytest.mark.parametrize("modes", [[FIRST], [FIRST, SECOND], [FIRST, FAST]])
def test_ring_down(modes: list[Mode]) -> None:
    of = model(modes)
    plant = Plant(of)
    for number in range(1, len(modes) + 1):
        plant.strike(number, 0.006 / number)
    start = np.array(
        [0.0, 0.0] + [v for n, m in enumerate(modes, 1) for v in (0.0, 2 * pi * m.frequency_hz * 0.006 / n)]
    )
    commands = np.zeros(300)
    assert_same(run(plant, commands), solved(of, commands, start))


@pytest.mark.parametrize("dead_time_s", [0.0, 0.0004, 0.001, 0.002, 0.0025, 0.0179])
def test_dead_time_of_any_length(dead_time_s: float) -> None:
    of = model(
        [FIRST, SECOND], Drive(dead_time_s=dead_time_s, max_velocity_rad_s=10.0, max_acceleration_rad_s2=1e4)
    )
    commands = moves(160, 0.4)
    assert_same(run(Plant(of), commands), solved(of, commands, np.zeros(6)))


def test_two_and_a_half_cycles_of_dead_time_are_exactly_that() -> None:
    of = model([FIRST], Drive(dead_time_s=0.0025))
    plant = Plant(of)
    velocities = run(plant, np.full(4, 0.1))[:, 1]
    assert np.all(velocities[:3] == 0.0)
    lag = 2.0 * pi * 20.0
    assert velocities[3] == pytest.approx(0.1 * (1.0 - np.exp(-lag * 0.0005)), rel=1e-12)
    assert velocities[4] == pytest.approx(0.1 * (1.0 - np.exp(-lag * 0.0015)), rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("bandwidth_hz", [5.0, 20.0, 300.0])
def test_moves_with_velocity_and_acceleration_limits(bandwidth_hz: float) -> None:
    drive = Drive(
        bandwidth_hz=bandwidth_hz, dead_time_s=0.0015, max_velocity_rad_s=0.3, max_acceleration_rad_s2=8.0
    )
    of = model([FIRST, SECOND], drive)
    commands = moves(400, 0.8)
    ours = run(Plant(of), commands)
    assert_same(
        ours, solved(of, commands, np.zeros(6)), 2e-6
    )  # the judge itself smears the corner of the limit
    steps = np.abs(np.diff(ours[:, 1]))
    assert np.max(steps) == pytest.approx(8.0 * CYCLE_S, rel=1e-9)
    assert np.max(np.abs(ours[:, 1])) <= 0.3


def test_many_fast_modes_under_a_moving_joint() -> None:
    modes = [
        Mode(frequency_hz=f, damping_ratio=0.01, participation=0.2)
        for f in (2.6, 16.0, 46.0, 90.0, 150.0, 400.0)
    ]
    of = model(modes)
    commands = moves(120, 0.4)
    assert_same(run(Plant(of), commands), solved(of, commands, np.zeros(14)))


def test_accelerations_and_tip_are_those_of_the_equations() -> None:
    plant = Plant(model([FIRST, SECOND], Drive(dead_time_s=0.0)))
    plant.strike(2, 0.001)
    plant.modal_forces_m_s2 = [0.3, -0.2]
    for command in moves(50, 0.4).tolist():
        plant.advance(command)
    joint = 2.0 * pi * 20.0 * (command - plant.joint_velocity_rad_s)
    assert plant.joint_acceleration_rad_s2 == pytest.approx(joint, rel=1e-9)
    tip = LENGTH_M * joint
    for mode, q, rate, force in zip(
        (FIRST, SECOND), plant.modal_deflections_m, plant.modal_rates_m_s, (0.3, -0.2), strict=True
    ):
        w = 2.0 * pi * mode.frequency_hz
        tip += force - mode.participation * LENGTH_M * joint - 2.0 * mode.damping_ratio * w * rate - w * w * q
    assert plant.tip_acceleration_m_s2 == pytest.approx(tip, rel=1e-9)
    assert plant.deflection_m == pytest.approx(sum(plant.modal_deflections_m), rel=1e-12)
    assert plant.tip_position_m == pytest.approx(
        LENGTH_M * plant.joint_position_rad + plant.deflection_m, rel=1e-12
    )
    slopes = tip_slopes_per_m(LENGTH_M, 2)
    bent = sum(s * q for s, q in zip(slopes, plant.modal_deflections_m, strict=True))
    assert plant.tip_angle_rad == pytest.approx(plant.joint_position_rad + bent, rel=1e-12)


def test_a_constant_force_bends_the_arm_by_force_over_stiffness() -> None:
    plant = Plant(model([Mode(frequency_hz=10.0, damping_ratio=0.5)]))
    plant.modal_forces_m_s2 = [2.0]
    run(plant, np.zeros(1500))
    assert plant.deflection_m == pytest.approx(2.0 / (2.0 * pi * 10.0) ** 2, rel=1e-9)


def test_an_effect_that_the_catalogue_does_not_allow_is_refused_by_name() -> None:
    of = Model(arm=Arm(length_m=2.0), effects=[{"cause": "gear_backlash", "gap_mm": 0.001}])
    with pytest.raises(UserError, match=r"^true\.toml: effects\[0\]\.gap_mm = 0\.001: [^\n]*gap_rad[^\n]*$"):
        Plant(of, "true.toml")


def test_a_model_without_a_length_is_refused() -> None:
    with pytest.raises(UserError, match=r"^true\.toml: arm\.length_m: [^\n]*$"):
        Plant(Model(), "true.toml")
