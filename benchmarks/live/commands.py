"""Whether a run's commands kept their limits and had their grounds. Recorded rows in, numbers out.

Limits are those of the model file. Grounds: the joint may be commanded in the states armed, damping and degraded
(docs/safety.md). In any other the command has to be on its way to zero, and to be there within 0.1 s.
"""

from collections.abc import Sequence
from math import isfinite

from stillarm.common.files.model import Drive
from stillarm.controller.safety.table import State

_MOVES = (State.ARMED, State.DAMPING, State.DEGRADED)
_FADED_WITHIN_S = 0.1  # from when the permission or the last ground is gone: docs/safety.md
_ROUNDING = 1e-9  # of a limit


def judge_commands(
    time_s: Sequence[float],
    command_rad_s: Sequence[float],
    state: Sequence[str],
    drive: Drive,
    cycle_s: float,
) -> dict[str, float | int]:
    """Count commands beyond the limits of velocity or acceleration, or not finite, and those without grounds.

    A step across missed cycles may be as large as one cycle allows: the limit is one of the command, not of the joint.
    """
    beyond = groundless = 0
    greatest = last = 0.0
    granted_s = float("-inf")
    step = drive.max_acceleration_rad_s2 * cycle_s * (1.0 + _ROUNDING) + _ROUNDING
    limit = drive.max_velocity_rad_s * (1.0 + _ROUNDING)
    for at_s, command, there in zip(time_s, command_rad_s, state, strict=True):
        if there in _MOVES:
            granted_s = at_s
        if not isfinite(command) or abs(command) > limit or abs(command - last) > step:
            beyond += 1
        if command != 0.0 and at_s > granted_s + _FADED_WITHIN_S:
            groundless += 1
        last = command if isfinite(command) else last
        greatest = max(greatest, abs(last))
    return {
        "command_max_rad_s": greatest,
        "commands_beyond_limits": beyond,
        "commands_without_grounds": groundless,
    }
