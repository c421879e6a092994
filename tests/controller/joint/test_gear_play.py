"""The joint behind a play, against a finer integration of the same play; the motor's way across it."""

from math import exp, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.files.model import Drive
from stillarm.controller.joint.drive_model import DriveModel
from stillarm.controller.joint.gear_play import GearPlay, PlayCrossing

CYCLE_S = 0.001
DRIVE = Drive(bandwidth_hz=20.0, dead_time_s=0.002, max_velocity_rad_s=2.0, max_acceleration_rad_s2=200.0)


def finely(gap_rad: float, commands: list[float]) -> list[float]:
    """theta at the end of each cycle: a play operator behind a first-order lag, a hundred steps a cycle."""
    steps, half = 100, 0.5 * gap_rad
    stay = exp(-2.0 * pi * DRIVE.bandwidth_hz * CYCLE_S / steps)
    motor = velocity = theta = 0.0
    positions = []
    for cycle in range(len(commands)):
        late = commands[cycle - 2] if cycle >= 2 else 0.0
        for _ in range(steps):
            after = late + (velocity - late) * stay
            motor += 0.5 * (velocity + after) * CYCLE_S / steps
            velocity = after
            theta = min(max(theta, motor - half), motor + half)
        positions.append(theta)
    return positions


@pytest.mark.slow
@settings(max_examples=20)
@given(gap_rad=st.floats(0.001, 0.02), size=st.floats(0.05, 0.5), frequency_hz=st.floats(0.3, 4.0))
def test_the_joint_moves_as_a_play_operator_has_it(gap_rad: float, size: float, frequency_hz: float) -> None:
    play = GearPlay(DriveModel(DRIVE, CYCLE_S), gap_rad, False, CYCLE_S)
    commands = [size * sin(2.0 * pi * frequency_hz * k * CYCLE_S) for k in range(1500)]
    positions, moved = [], 0.0
    for command in commands:
        before = play.velocity_rad_s
        play.advance(command)
        positions.append(play.position_rad)
        moved += play.mean_acceleration_rad_s2 * CYCLE_S
        assert play.velocity_rad_s == pytest.approx(before + play.mean_acceleration_rad_s2 * CYCLE_S)
        assert abs(play.ahead_rad) <= 0.5 * gap_rad
    assert np.max(np.abs(np.array(positions) - finely(gap_rad, commands))) < 0.02 * gap_rad + 1e-5
    assert moved == pytest.approx(play.velocity_rad_s)


@pytest.mark.parametrize("on_motor", [False, True])
def test_the_encoder_is_read_on_the_side_where_it_sits(on_motor: bool) -> None:
    play = GearPlay(DriveModel(DRIVE, CYCLE_S), 0.01, on_motor, CYCLE_S)
    for _ in range(200):
        play.advance(0.2)
    assert play.ahead_rad == 0.005
    play.report(0.3)
    assert play.position_rad == pytest.approx(0.295 if on_motor else 0.3)


def test_the_motor_crosses_before_the_joint_has_to_turn_and_does_not_overshoot() -> None:
    """A joint velocity a cos(w t) is asked for; the other flank is met within a tenth of a period of its zero."""
    w, size, gap = 16.0, 0.1, 0.01
    play = GearPlay(DriveModel(DRIVE, CYCLE_S), gap, False, CYCLE_S)
    lead = 0.002 + 1.0 / (2.0 * pi * DRIVE.bandwidth_hz)
    crossing = PlayCrossing(gap, lead, w, CYCLE_S)
    sides = []
    for k in range(2000):
        answered = k * CYCLE_S + lead
        wanted, rate = size * np.cos(w * answered), -size * w * np.sin(w * answered)
        play.advance(wanted + crossing.velocity_rad_s(wanted, rate, play))
        sides.append((k * CYCLE_S, play.ahead_rad))
    period = 2.0 * pi / w
    for turn in range(2, 8):
        zero = (turn + 0.5) * 0.5 * period
        wanted_side = 0.5 * gap if turn % 2 else -0.5 * gap
        met = min(
            t for t, ahead in sides if t > zero - 0.25 * period and abs(ahead - wanted_side) < 0.05 * gap
        )
        assert abs(met - zero) < 0.1 * period


def test_a_vibration_that_is_not_worth_it_is_left_alone() -> None:
    play = GearPlay(DriveModel(DRIVE, CYCLE_S), 0.01, False, CYCLE_S)
    crossing = PlayCrossing(0.01, 0.01, 16.0, CYCLE_S)
    assert crossing.velocity_rad_s(0.003, 0.0, play) == 0.0
    assert crossing.velocity_rad_s(0.1, 0.0, play) > 0.0 > crossing.velocity_rad_s(-0.1, 0.0, play)
