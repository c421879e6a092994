"""Commands beyond their limits, and without grounds."""

from math import inf, nan

import pytest

from stillarm.benchmarks.live.commands import judge_commands
from stillarm.common.files.model import Drive


def judged(commands: list[float], states: list[str]) -> dict[str, float | int]:
    drive = Drive(max_velocity_rad_s=0.6, max_acceleration_rad_s2=20.0)
    return judge_commands([0.001 * k for k in range(len(commands))], commands, states, drive, 0.001)


def test_commands_beyond_a_limit_are_counted() -> None:
    """20 mrad/s a cycle, 0.6 rad/s at the most; what is not finite is beyond any limit."""
    ramp = [0.02 * k for k in range(31)]
    assert judged(ramp, ["armed"] * 31)["commands_beyond_limits"] == 0
    assert judged([*ramp, 0.61], ["armed"] * 32)["commands_beyond_limits"] == 1
    assert judged([0.0, 0.03], ["armed"] * 2)["commands_beyond_limits"] == 1
    for wrong in (nan, inf):
        assert judged([0.0, wrong, 0.0], ["armed"] * 3)["commands_beyond_limits"] == 1
    assert judged(ramp, ["armed"] * 31)["command_max_rad_s"] == pytest.approx(0.6)


def test_commands_without_grounds_are_counted_once_the_time_to_fade_is_over() -> None:
    """0.1 s after the permission is gone; before any was given, at once."""
    states = ["damping"] * 10 + ["idle"] * 300
    fading = [0.01] * 10 + [0.01 * (1.0 - k / 90.0) for k in range(90)] + [0.0] * 210
    assert judged(fading, states)["commands_without_grounds"] == 0
    assert judged([0.01] * 310, states)["commands_without_grounds"] == pytest.approx(200, abs=1)
    assert judged([0.01, 0.01], ["idle", "idle"])["commands_without_grounds"] == 2
