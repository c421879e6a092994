"""The joint, compiled: a drive that follows its command with a lag and within limits, and the play behind it.

    theta'' = clip(decay (command - theta'), max_acceleration),   decay = 2 pi bandwidth

between the end stops; a joint that runs into one stops there at once. While the command is constant the motion is a
stretch of constant theta'' followed by one of exponentially decaying theta'', so it is solved exactly, piece by piece.
With play of width `gap` the link stands still while the motor crosses it, and moves with the motor otherwise; where the
motor meets the other flank theta' jumps to the motor's velocity, which is an impulse of theta''.

A joint that is driven otherwise (by a torque, say) is another function that fills the same stretches.
"""

from enum import IntEnum

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

_BISECTIONS = 60  # to the last bit of a duration within a step
MOST_STRETCHES = (
    64  # of a cycle: two holds, each with a limit, two stops, and a turn and a contact of the play in each
)


class J(IntEnum):
    """Places in the joint's state. ahead: motor's angle less the link's, rad; contact: 1 where both move together."""

    MOTOR = 0
    MOTOR_RATE = 1
    MOTOR_ACCELERATION = 2
    AHEAD = 3
    CONTACT = 4
    SIZE = 5


class D(IntEnum):
    """Places in the drive's constants. early: part of a cycle, s, in which the command before still acts; late: the
    rest."""

    DECAY = 0
    MAX_ACCELERATION = 1
    LOWEST = 2
    HIGHEST = 3
    GAP = 4
    EARLY = 5
    LATE = 6
    SIZE = 7


class S(IntEnum):
    """Places in a stretch of the link's motion, in which theta'' = start exp(-decay t) from `theta` and `omega` on, and
    theta' jumps at its end (an impact)."""

    DURATION = 0
    DECAY = 1
    START = 2
    JUMP = 3
    THETA = 4
    OMEGA = 5
    SIZE = 6


# numba takes plain numbers for constants at the least cost to compile
_MOTOR, _RATE, _ACCELERATION, _AHEAD, _CONTACT = 0, 1, 2, 3, 4


@njit(cache=True, nogil=True, error_model="numpy")
def risen(decay: float, t: float) -> float:
    """Integral of exp(-decay t), s."""
    return t if decay == 0.0 else -np.expm1(-decay * t) / decay


@njit(cache=True, nogil=True, error_model="numpy")
def way(omega: float, decay: float, start: float, t: float) -> float:
    """Angle travelled in t, rad, from velocity omega under theta'' = start exp(-decay t)."""
    if decay == 0.0:
        return t * (omega + 0.5 * start * t)
    return omega * t + start / decay * (t - risen(decay, t))


@njit(cache=True, nogil=True, error_model="numpy")
def _turn(omega: float, decay: float, start: float, duration: float) -> float:
    """When the velocity passes through zero; the stretch's end where it does not within it."""
    if omega * start >= 0.0:
        return duration
    if decay == 0.0:
        return min(duration, -omega / start)
    share = omega * decay / start  # negative
    return min(duration, -np.log1p(share) / decay) if share > -1.0 else duration


@njit(cache=True, nogil=True, error_model="numpy")
def _reaches(
    omega: float, decay: float, start: float, aim: float, side: float, before: float, after: float
) -> float:
    """The instant from which the way is at or beyond `aim` on a side (+1, -1): not so at `before`, so at `after`."""
    for _ in range(_BISECTIONS):
        middle = 0.5 * (before + after)
        if side * (way(omega, decay, start, middle) - aim) >= 0.0:
            after = middle
        else:
            before = middle
    return after


@njit(cache=True, nogil=True, error_model="numpy")
def _add(
    stretches: Array,
    count: int,
    duration: float,
    decay: float,
    start: float,
    jump: float,
    theta: float,
    omega: float,
) -> int:
    """One more stretch; returns how many there are."""
    if count < stretches.shape[0]:
        stretches[count, 0], stretches[count, 1], stretches[count, 2] = duration, decay, start
        stretches[count, 3], stretches[count, 4], stretches[count, 5] = jump, theta, omega
        return count + 1
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _span_behind_play(
    joint: Array, gap: float, omega: float, decay: float, start: float, begin: float, end: float,
    stretches: Array, count: int, motor: float,
) -> int:  # fmt: skip
    """The link's stretches over a span in which the motor, at `motor` when its own stretch began, does not turn."""
    passed = way(omega, decay, start, begin)
    across = way(omega, decay, start, end) - passed
    link = motor + passed - joint[_AHEAD]
    if across == 0.0:
        joint[_CONTACT] = 0.0
        return _add(stretches, count, end - begin, 0.0, 0.0, 0.0, link, 0.0)
    side = 1.0 if across > 0.0 else -1.0
    flank = side * 0.5 * gap
    rate = omega + start * risen(decay, begin)
    if joint[_AHEAD] == flank:
        joint[_CONTACT] = 1.0
        return _add(stretches, count, end - begin, decay, start * np.exp(-decay * begin), 0.0, link, rate)
    joint[_CONTACT] = 0.0
    ahead = joint[_AHEAD] + across
    if (flank - ahead) * across > 0.0:  # by the sum as rounded: what is on the flank later has struck it now
        joint[_AHEAD] = ahead
        return _add(stretches, count, end - begin, 0.0, 0.0, 0.0, link, 0.0)
    contact = _reaches(omega, decay, start, flank - joint[_AHEAD] + passed, side, begin, end)
    joint[_AHEAD], joint[_CONTACT] = flank, 1.0
    rate = omega + start * risen(decay, contact)
    count = _add(stretches, count, contact - begin, 0.0, 0.0, rate, link, 0.0)
    if end > contact:
        count = _add(
            stretches, count, end - contact, decay, start * np.exp(-decay * contact), 0.0, link, rate
        )
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _link(
    joint: Array, gap: float, duration: float, decay: float, start: float, jump: float,
    stretches: Array, count: int,
) -> int:  # fmt: skip
    """What the link makes of the motor's next stretch, from the motor's state before it."""
    motor, omega = joint[_MOTOR], joint[_RATE]
    if gap == 0.0:
        return _add(stretches, count, duration, decay, start, jump, motor, omega)
    turn = _turn(omega, decay, start, duration)
    if turn > 0.0:
        count = _span_behind_play(joint, gap, omega, decay, start, 0.0, turn, stretches, count, motor)
    if duration > turn:
        count = _span_behind_play(joint, gap, omega, decay, start, turn, duration, stretches, count, motor)
    if jump != 0.0 and joint[_CONTACT] == 1.0:  # the motor's own end stop
        theta = motor + way(omega, decay, start, duration) - joint[_AHEAD]
        count = _add(stretches, count, 0.0, 0.0, 0.0, jump, theta, -jump)
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _move(
    joint: Array, drive: Array, duration: float, decay: float, start: float, stretches: Array, count: int
) -> tuple[float, int]:
    """Move the motor under theta'' = start exp(-decay t), or to its first impact on an end stop: the time used, and how
    many stretches there are."""
    lowest, highest, theta, omega = drive[2], drive[3], joint[_MOTOR], joint[_RATE]
    most = (abs(omega) + abs(start) * duration) * duration
    jump = 0.0
    stop = theta
    if theta - most < lowest or theta + most > highest:
        turn = _turn(omega, decay, start, duration)
        before = 0.0
        for after in (turn, duration):
            there = theta + way(omega, decay, start, after)
            if lowest <= there <= highest:
                before = after
                continue
            stop, side = (highest, 1.0) if there > highest else (lowest, -1.0)
            duration = _reaches(omega, decay, start, stop - theta, side, before, after)
            jump = -(omega + start * risen(decay, duration))
            break
    count = _link(joint, drive[4], duration, decay, start, jump, stretches, count)
    if jump != 0.0:
        joint[_MOTOR], joint[_RATE], joint[_ACCELERATION] = stop, 0.0, 0.0
    else:
        joint[_MOTOR] = min(max(theta + way(omega, decay, start, duration), lowest), highest)
        joint[_RATE] = omega + start * risen(decay, duration)
        joint[_ACCELERATION] = start * np.exp(-decay * duration)
    return duration, count


@njit(cache=True, nogil=True, error_model="numpy")
def hold(joint: Array, drive: Array, span: float, target: float, stretches: Array, count: int) -> int:
    """Move for `span` s towards the constant velocity `target`, rad/s; returns how many stretches there are now."""
    decay, most = drive[0], drive[1]
    linear = most / decay
    while span > 0.0 and count < stretches.shape[0]:
        theta, omega = joint[_MOTOR], joint[_RATE]
        if omega == 0.0 and ((theta >= drive[3] and target >= 0.0) or (theta <= drive[2] and target <= 0.0)):
            joint[_ACCELERATION] = 0.0
            return _link(joint, drive[4], span, 0.0, 0.0, 0.0, stretches, count)
        error = target - omega
        excess = abs(error) - linear
        # what rounding leaves of an excess must not count as one, or the loop would never end
        if excess > 1e-12 * (linear + abs(target) + abs(omega)):
            start = most if error > 0.0 else -most
            used, count = _move(joint, drive, min(span, excess / most), 0.0, start, stretches, count)
        else:
            used, count = _move(joint, drive, span, decay, decay * error, stretches, count)
        span -= used
    return count
