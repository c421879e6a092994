"""The drive model against an integration with a hundred times finer step, written apart from it."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.files.model import Drive
from stillarm.controller.joint.drive_model import DriveModel, drive_lead_s

FINE = 100


def reference(drive: Drive, commands: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity at the end of each 1 ms cycle, by small Euler steps."""
    h = 0.001 / FINE
    wait = round(drive.dead_time_s / h)
    fine = np.concatenate((np.zeros(wait), np.repeat(commands, FINE)))
    position = velocity = 0.0
    positions, velocities = [], []
    limit = drive.max_acceleration_rad_s2
    for k in range(len(commands) * FINE):
        wanted = np.clip(fine[k], -drive.max_velocity_rad_s, drive.max_velocity_rad_s)
        acceleration = np.clip(2 * pi * drive.bandwidth_hz * (wanted - velocity), -limit, limit)
        position += h * velocity + 0.5 * h * h * acceleration
        velocity += h * acceleration
        if (k + 1) % FINE == 0:
            positions.append(position)
            velocities.append(velocity)
    return np.array(positions), np.array(velocities)


@pytest.mark.slow
@given(dead_time_s=st.floats(0.0, 0.006), bandwidth_hz=st.floats(3.0, 40.0), seed=st.integers(0, 100))
@settings(max_examples=8, deadline=None, derandomize=True)
def test_follows_the_finer_integration(dead_time_s: float, bandwidth_hz: float, seed: int) -> None:
    """For smooth commands as in damping: velocity and position within 1 % of their spans."""
    drive = Drive(dead_time_s=dead_time_s, bandwidth_hz=bandwidth_hz)
    random = np.random.default_rng(seed)
    t = np.arange(400) * 0.001
    commands = [
        float(v)
        for v in 0.05 * np.sin(2 * pi * 2.6 * t + random.uniform(0, 6)) + 0.02 * np.sin(2 * pi * 7 * t)
    ]
    model = DriveModel(drive, 0.001)
    got = []
    for command in commands:
        model.advance(command)
        got.append((model.position_rad, model.velocity_rad_s))
    positions, velocities = reference(drive, commands)
    assert np.max(np.abs(np.array(got)[:, 0] - positions)) < 0.01 * np.ptp(positions)
    assert np.max(np.abs(np.array(got)[:, 1] - velocities)) < 0.012 * np.ptp(velocities)


def test_limits_hold() -> None:
    """Velocity, acceleration, position."""
    drive = Drive(max_velocity_rad_s=0.3, max_acceleration_rad_s2=2.0, max_position_rad=0.1)
    model = DriveModel(drive, 0.001)
    last = 0.0
    for _ in range(2000):
        model.advance(5.0)
        assert abs(model.velocity_rad_s) <= 0.3
        assert model.position_rad <= 0.1
        if model.position_rad < 0.1:
            assert model.velocity_rad_s - last <= 2.0 * 0.001 + 1e-12
        last = model.velocity_rad_s
    assert model.position_rad == pytest.approx(0.1)


def test_lead_is_the_phase_of_dead_time_and_lag() -> None:
    """At 2.6 Hz through 20 Hz and 2 ms: a complex number says the same."""
    w = 2 * pi * 2.6
    response = np.exp(-1j * w * 0.002) / (1 + 1j * 2.6 / 20.0)
    assert drive_lead_s(Drive(), w) == pytest.approx(-np.angle(response) / w)
