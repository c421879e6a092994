"""The command that makes the simulated joint move as the real one was measured."""

import numpy as np
import pytest

from stillarm.common.files.model import Drive
from stillarm.diagnosis.data.reading import imposed_command

CYCLE_S = 0.001
TIME = np.arange(6000) * CYCLE_S
OMEGA = 0.2 * np.sin(2.0 * np.pi * 0.7 * TIME) * np.clip(TIME - 0.5, 0.0, 1.0)
THETA = np.cumsum(OMEGA) * CYCLE_S
NONE = np.full(len(TIME), np.nan)


def answer(command: np.ndarray, drive: Drive) -> np.ndarray:
    """First-order lag after a dead time, by Euler's method in small steps."""
    rate, late = 2.0 * np.pi * drive.bandwidth_hz, round(drive.dead_time_s / CYCLE_S)
    sent = np.concatenate((np.zeros(late), command))[: len(command)]
    omega, found = 0.0, np.empty(len(sent))
    for k, value in enumerate(sent):
        for _ in range(10):
            omega += 0.1 * CYCLE_S * rate * (value - omega)
        found[k] = omega
    return found


@pytest.mark.parametrize("by", ["velocity", "position"])
def test_the_drive_answers_it_with_the_measured_motion(by: str) -> None:
    drive = Drive(bandwidth_hz=10.0, dead_time_s=0.004)
    rng = np.random.default_rng(5)
    velocity = OMEGA + rng.normal(0.0, 1e-3, len(TIME)) if by == "velocity" else NONE
    position = THETA + rng.normal(0.0, 1e-6, len(TIME)) if by == "position" else NONE
    position[1000:1020] = np.nan
    command = imposed_command(position, velocity, drive, CYCLE_S)
    assert command is not None
    off = (answer(command, drive) - OMEGA)[100:-100]
    assert np.sqrt(np.mean(off**2)) < 0.02 * np.std(OMEGA)


def test_a_joint_that_stands_or_was_not_measured_has_none() -> None:
    noise = np.random.default_rng(5).normal(0.0, 1e-4, len(TIME))
    assert imposed_command(NONE, noise, Drive(), CYCLE_S) is None
    assert imposed_command(NONE, NONE, Drive(), CYCLE_S) is None
