"""The joint, compiled: a drive that follows its command with a lag and within limits, and the play behind it.

    theta'' = clip(decay (command - theta'), most),   decay = 2 pi bandwidth

between the end stops; a joint that runs into one stops there at once. While the command is constant the motion is a
stretch of constant theta'' followed by one of exponentially decaying theta'', so it is solved exactly, piece by piece.
With play of width `gap` the link stands still while the motor crosses it, and moves with the motor otherwise; where the
motor meets the other flank theta' jumps to the motor's velocity, which is an impulse of theta''.

A joint that is driven otherwise (by a torque, say) is another function that fills the same stretches.
"""

import numpy as np

from stillarm.simulation.arm.compiler import compiled, inlined, nth
from stillarm.simulation.arm.state import MOST_STRETCHES, Record

_MOST_STRETCHES = MOST_STRETCHES - 8  # a move adds no more
_BISECTIONS = 60  # to the last bit of a duration within a step


@inlined
def risen(decay: float, t: float) -> float:
    """Integral of exp(-decay t), s."""
    return t if decay == 0.0 else -np.expm1(-decay * t) / decay


@inlined
def way(omega: float, decay: float, start: float, t: float) -> float:
    """Angle travelled in t, rad, from velocity omega under theta'' = start exp(-decay t)."""
    if decay == 0.0:
        return t * (omega + 0.5 * start * t)
    return omega * t + start / decay * (t - risen(decay, t))


@inlined
def _turn(omega: float, decay: float, start: float, duration: float) -> float:
    """Time at which the velocity passes through zero; the stretch's end if it does not."""
    if omega * start >= 0.0:
        return duration
    if decay == 0.0:
        return min(duration, -omega / start)
    share = omega * decay / start  # negative
    return min(duration, -np.log1p(share) / decay) if share > -1.0 else duration


@compiled
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


@inlined
def _add(
    arm: Record, count: int, duration: float, decay: float, start: float, end: float, jump: float,
    theta: float, omega: float,
) -> int:  # fmt: skip
    """One more stretch; returns how many there are."""
    one = nth(arm.stretch, count)
    one.duration, one.decay, one.start, one.end = duration, decay, start, end
    one.jump, one.theta, one.omega = jump, theta, omega
    return count + 1


@compiled
def _behind_play(
    arm: Record,
    omega: float,
    decay: float,
    start: float,
    begin: float,
    end: float,
    count: int,
) -> int:
    """The link's stretches over a span in which the motor does not turn, of a stretch that it begins with omega."""
    passed = way(omega, decay, start, begin)
    across = way(omega, decay, start, end) - passed
    link = arm.motor + passed - arm.ahead
    if across == 0.0:
        arm.contact = 0.0
        return _add(arm, count, end - begin, 0.0, 0.0, 0.0, 0.0, link, 0.0)
    side = 1.0 if across > 0.0 else -1.0
    flank = side * 0.5 * arm.gap
    first, last = start * np.exp(-decay * begin), start * np.exp(-decay * end)
    if arm.ahead == flank:
        arm.contact = 1.0
        rate = omega + start * risen(decay, begin)
        return _add(arm, count, end - begin, decay, first, last, 0.0, link, rate)
    arm.contact = 0.0
    ahead = arm.ahead + across
    if (flank - ahead) * across > 0.0:  # by the sum as rounded: what is on the flank later has struck it now
        arm.ahead = ahead
        return _add(arm, count, end - begin, 0.0, 0.0, 0.0, 0.0, link, 0.0)
    contact = _reaches(omega, decay, start, flank - arm.ahead + passed, side, begin, end)
    arm.ahead, arm.contact = flank, 1.0
    rate = omega + start * risen(decay, contact)
    count = _add(arm, count, contact - begin, 0.0, 0.0, 0.0, rate, link, 0.0)
    if end > contact:
        first = start * np.exp(-decay * contact)
        count = _add(arm, count, end - contact, decay, first, last, 0.0, link, rate)
    return count


@inlined
def _link(
    arm: Record,
    duration: float,
    decay: float,
    start: float,
    end: float,
    jump: float,
    count: int,
) -> int:
    """The link's motion in the motor's next stretch, from the motor's state before it."""
    omega = arm.rate
    if arm.gap == 0.0:
        return _add(arm, count, duration, decay, start, end, jump, arm.motor, omega)
    turn = _turn(omega, decay, start, duration)
    if turn > 0.0:
        count = _behind_play(arm, omega, decay, start, 0.0, turn, count)
    if duration > turn:
        count = _behind_play(arm, omega, decay, start, turn, duration, count)
    if jump != 0.0 and arm.contact == 1.0:  # the motor's own end stop
        theta = arm.motor + way(omega, decay, start, duration) - arm.ahead
        count = _add(arm, count, 0.0, 0.0, 0.0, 0.0, jump, theta, -jump)
    return count


@compiled
def _strikes(arm: Record, decay: float, start: float, duration: float) -> tuple[float, float, float]:
    """The motor's first impact on an end stop in a stretch: when, where, and its velocity then; else the stretch's
    duration and no velocity."""
    theta, omega = arm.motor, arm.rate
    turn = _turn(omega, decay, start, duration)
    before = 0.0
    for after in (turn, duration):
        there = theta + way(omega, decay, start, after)
        if arm.lowest <= there <= arm.highest:
            before = after
            continue
        stop, side = (arm.highest, 1.0) if there > arm.highest else (arm.lowest, -1.0)
        instant = _reaches(omega, decay, start, stop - theta, side, before, after)
        return instant, stop, omega + start * risen(decay, instant)
    return duration, theta, 0.0


@inlined
def lagging(
    omega: float, decay: float, start: float, duration: float, lasted: float
) -> tuple[float, float, float]:
    """Angle travelled, rad, gain of velocity, rad/s, and theta'' at the end of a duration under theta'' = start
    exp(-decay t). lasted: the integral of exp(-decay t) over it, s."""
    passed = omega * duration + start / decay * (duration - lasted)
    return passed, start * lasted, start * (1.0 - decay * lasted)


@inlined
def move(arm: Record, duration: float, decay: float, start: float, count: int) -> tuple[float, int]:
    """Move the motor under theta'' = start exp(-decay t), or to its first impact on an end stop: the time used, and how
    many stretches there are."""
    most = (abs(arm.rate) + abs(start) * duration) * duration
    if arm.motor - most < arm.lowest or arm.motor + most > arm.highest:
        instant, stop, velocity = _strikes(arm, decay, start, duration)
        if velocity != 0.0:
            end = start * np.exp(-decay * instant)
            count = _link(arm, instant, decay, start, end, -velocity, count)
            arm.motor, arm.rate, arm.acceleration = stop, 0.0, 0.0
            return instant, count
    if decay == 0.0:
        end, rise = start, start * duration
        passed = duration * (arm.rate + 0.5 * start * duration)
    else:
        lasted = (
            arm.late_risen if duration == arm.late
            else arm.early_risen if duration == arm.early
            else risen(decay, duration)
        )  # fmt: skip
        passed, rise, end = lagging(arm.rate, decay, start, duration, lasted)
    count = _link(arm, duration, decay, start, end, 0.0, count)
    arm.motor = min(max(arm.motor + passed, arm.lowest), arm.highest)
    arm.rate += rise
    arm.acceleration = end
    return duration, count


@inlined
def pressed_on(arm: Record, push: float) -> bool:
    """Whether the motor stands at an end stop and a push, of which the sign counts, holds it there."""
    return bool(
        arm.rate == 0.0
        and ((arm.motor >= arm.highest and push >= 0.0) or (arm.motor <= arm.lowest and push <= 0.0))
    )


@inlined
def hold(arm: Record, span: float, target: float, count: int) -> int:
    """Move for `span` s towards the constant velocity `target`, rad/s; returns how many stretches there are now."""
    linear = arm.most / arm.decay
    while span > 0.0 and count < _MOST_STRETCHES:
        omega = arm.rate
        if pressed_on(arm, target):
            arm.acceleration = 0.0
            return _link(arm, span, 0.0, 0.0, 0.0, 0.0, count)
        error = target - omega
        excess = abs(error) - linear
        # what rounding leaves of an excess must not count as one, or the loop would never end
        if excess > 1e-12 * (linear + abs(target) + abs(omega)):
            start = arm.most if error > 0.0 else -arm.most
            used, count = move(arm, min(span, excess / arm.most), 0.0, start, count)
        else:
            used, count = move(arm, span, arm.decay, arm.decay * error, count)
        span -= used
    return count
