"""The joint's limits hold for every demand, against an integration of the joint written apart."""

from math import inf, nan, pi

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.files.model import Drive
from stillarm.controller.command.limits import CommandLimits

DRIVE = Drive(min_position_rad=-0.2, max_position_rad=0.3)
demand = st.one_of(st.floats(-50.0, 50.0), st.sampled_from((nan, inf, -inf)))


@given(st.lists(st.tuples(demand, st.integers(1, 400)), min_size=1, max_size=8))
@settings(max_examples=60, deadline=None)
def test_no_demand_passes_a_limit(demands: list[tuple[float, int]]) -> None:
    """Velocity and acceleration of the command, and position of a joint that lags by 20 Hz and 2 ms."""
    limits, last, position, velocity = CommandLimits(DRIVE, 0.001), 0.0, 0.0, 0.0
    waiting = [0.0, 0.0]
    for wanted, cycles in demands:
        for _ in range(cycles):
            command = limits.bound(wanted, position)
            assert abs(command) <= DRIVE.max_velocity_rad_s
            assert abs(command - last) <= DRIVE.max_acceleration_rad_s2 * 0.001 * (1 + 1e-9)
            last = command
            waiting.append(command)
            now = waiting.pop(0)
            for _ in range(5):
                velocity += 0.0002 * 2 * pi * DRIVE.bandwidth_hz * (now - velocity)
                position += 0.0002 * velocity
            assert DRIVE.min_position_rad <= position <= DRIVE.max_position_rad


def test_the_limit_is_reached_and_left_again() -> None:
    """Bounding must not freeze the joint short of its range."""
    limits, position = CommandLimits(DRIVE, 0.001), 0.0
    for _ in range(3000):
        position += 0.001 * limits.bound(1.0, position)
    assert position == pytest.approx(0.3, abs=0.01)
    for _ in range(3000):
        position += 0.001 * limits.bound(-1.0, position)
    assert position == pytest.approx(-0.2, abs=0.01)


def test_an_unknown_position_lets_nothing_through() -> None:
    """NaN position or demand: the command goes to zero within the acceleration limit."""
    limits = CommandLimits(DRIVE, 0.001)
    for _ in range(100):
        limits.bound(0.5, 0.0)
    for _ in range(40):
        command = limits.bound(0.5, nan)
    assert command == 0.0
