"""Play: the joint against the play operator, the arm against scipy."""

from math import exp, pi

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from stillarm.common.files.model import Arm, Drive, Mode, Model
from stillarm.simulation.arm.plant import Plant
from tests.fixtures.driven_joint import rig
from tests.reference.effects_judge import bent_by_joint
from tests.reference.plant_judge import moves

CYCLE_S = 0.001


LAG = 2.0 * pi * 20.0


GAP = 0.004


def played(motor: np.ndarray, gap: float) -> np.ndarray:
    """The play operator on a finely sampled motion: theta is pushed by whichever flank the motor leans on."""
    theta, out = 0.0, np.empty(len(motor))
    for index, position in enumerate(motor):
        theta = min(max(theta, position - 0.5 * gap), position + 0.5 * gap)
        out[index] = theta
    return out


@pytest.mark.slow
def test_backlash_moves_joint_and_arm_as_the_play_operator_and_scipy_say() -> None:
    """Motor: exact first-order lag; joint: play operator at 50 kHz; arm: an equation that needs no theta''."""
    fine, cycles = 50, 1500
    commands = np.repeat([0.1, -0.1, 0.05, -0.12, 0.0], cycles // 5)
    step = CYCLE_S / fine
    motor, velocity, position = [0.0], 0.0, 0.0
    for command in commands:
        for _ in range(fine):
            decayed = exp(-LAG * step)
            position += command * step + (velocity - command) * (1.0 - decayed) / LAG
            velocity = command + (velocity - command) * decayed
            motor.append(position)
    joint = played(np.array(motor), GAP)
    plant, found = rig({"cause": "gear_backlash", "gap_rad": GAP}), []
    for command in commands.tolist():
        plant.advance(command)
        found.append((plant.joint_position_rad, plant.deflection_m, plant.encoder_position_rad))
    ours = np.array(found)
    assert ours[:, 0] == pytest.approx(joint[fine::fine], abs=1e-9)
    assert np.array_equal(ours[:, 2], ours[:, 0])
    bent, stiff = (bent_by_joint(theta, step)[fine::fine] for theta in (joint, np.array(motor)))
    assert np.max(np.abs(ours[:, 1] - bent)) < 1e-4 * np.max(np.abs(bent))
    assert np.max(np.abs(stiff - bent)) > 0.02 * np.max(np.abs(bent))


def test_an_encoder_before_the_gear_shows_the_motor() -> None:
    effect = {"cause": "gear_backlash", "gap_rad": GAP, "behind_encoder": True}
    plant, free = rig(effect), rig()
    commands = moves(400, 0.1).tolist()
    for command in commands:
        plant.advance(command)
        free.advance(command)
        assert plant.encoder_position_rad == free.joint_position_rad
        assert plant.encoder_velocity_rad_s == free.joint_velocity_rad_s
        assert abs(plant.joint_position_rad - free.joint_position_rad) <= 0.5 * GAP + 1e-15
    assert plant.joint_position_rad != free.joint_position_rad


@settings(max_examples=40, deadline=None)
@given(
    gap=st.floats(1e-6, 0.2),
    seed=st.integers(0, 2**32 - 1),
    amplitude=st.floats(1e-3, 2.0),
    stop=st.floats(0.005, 0.5),
)
@example(gap=0.0005, seed=2, amplitude=1.0, stop=0.5)  # the flank is met as a cycle ends
def test_theta_never_leaves_the_play_and_the_arm_feels_all_of_its_motion(
    gap: float, seed: int, amplitude: float, stop: float
) -> None:
    """For any command, also at the motor's end stops."""
    drive = Drive(min_position_rad=-stop, max_position_rad=stop)
    limp = Arm(length_m=2.0, modes=[Mode(frequency_hz=0.01, damping_ratio=0.0, participation=1.0)])
    backlash = {"cause": "gear_backlash", "gap_rad": gap}
    plant, free = (Plant(Model(arm=limp, drive=drive, effects=e)) for e in ([backlash], []))  # type: ignore[list-item]
    reach = 0.0
    for command in moves(200, amplitude, seed).tolist():
        plant.advance(command)
        free.advance(command)
        assert abs(free.joint_position_rad - plant.joint_position_rad) <= 0.5 * gap * (1.0 + 1e-9)
        assert plant.joint_velocity_rad_s in (0.0, free.joint_velocity_rad_s)
        # a mode this limp follows q = - participation length theta, but for (w T)^2 / 2 = 8e-5 of the way
        reach = max(reach, abs(2.0 * plant.joint_position_rad))
        assert plant.deflection_m == pytest.approx(-2.0 * plant.joint_position_rad, abs=1e-4 * reach + 1e-15)
