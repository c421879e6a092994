"""The joint, compiled: a drive that follows its command with a lag and within limits, and the play behind it.

    theta'' = clip(decay (command - theta'), most),   decay = 2 pi bandwidth

between the end stops; a joint that runs into one stops there at once. While the command is constant the motion is a
stretch of constant theta'' followed by one of exponentially decaying theta'', so it is solved exactly, piece by piece.
With play of width `gap` the link stands still while the motor crosses it, and moves with the motor otherwise; where the
motor meets the other flank theta' jumps to the motor's velocity, which is an impulse of theta''.

A joint that is driven otherwise (by a torque, say) is another function that fills the same stretches.
"""

import numpy as np

from simulation.arm.compiler import compiled, inlined, nth
from simulation.arm.state import MOST_STRETCHES, Record

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
    """When the velocity passes through zero; the stretch's end where it does not within it."""
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
    stretches: Record, count: int, duration: float, decay: float, start: float, end: float, jump: float,
    theta: float, omega: float,
) -> int:  # fmt: skip
    """One more stretch; returns how many there are."""
    one = nth(stretches, count)
    one.duration, one.decay, one.start, one.end = duration, decay, start, end
    one.jump, one.theta, one.omega = jump, theta, omega
    return count + 1


@compiled
def _behind_play(
    joint: Record,
    omega: float,
    decay: float,
    start: float,
    begin: float,
    end: float,
    stretches: Record,
    count: int,
) -> int:
    """The link's stretches over a span in which the motor does not turn, of a stretch that it begins with omega."""
    passed = way(omega, decay, start, begin)
    across = way(omega, decay, start, end) - passed
    link = joint.motor + passed - joint.ahead
    if across == 0.0:
        joint.contact = 0.0
        return _add(stretches, count, end - begin, 0.0, 0.0, 0.0, 0.0, link, 0.0)
    side = 1.0 if across > 0.0 else -1.0
    flank = side * 0.5 * joint.gap
    first, last = start * np.exp(-decay * begin), start * np.exp(-decay * end)
    if joint.ahead == flank:
        joint.contact = 1.0
        rate = omega + start * risen(decay, begin)
        return _add(stretches, count, end - begin, decay, first, last, 0.0, link, rate)
    joint.contact = 0.0
    ahead = joint.ahead + across
    if (flank - ahead) * across > 0.0:  # by the sum as rounded: what is on the flank later has struck it now
        joint.ahead = ahead
        return _add(stretches, count, end - begin, 0.0, 0.0, 0.0, 0.0, link, 0.0)
    contact = _reaches(omega, decay, start, flank - joint.ahead + passed, side, begin, end)
    joint.ahead, joint.contact = flank, 1.0
    rate = omega + start * risen(decay, contact)
    count = _add(stretches, count, contact - begin, 0.0, 0.0, 0.0, rate, link, 0.0)
    if end > contact:
        first = start * np.exp(-decay * contact)
        count = _add(stretches, count, end - contact, decay, first, last, 0.0, link, rate)
    return count


@inlined
def _link(
    joint: Record,
    duration: float,
    decay: float,
    start: float,
    end: float,
    jump: float,
    stretches: Record,
    count: int,
) -> int:
    """What the link makes of the motor's next stretch, from the motor's state before it."""
    omega = joint.rate
    if joint.gap == 0.0:
        return _add(stretches, count, duration, decay, start, end, jump, joint.motor, omega)
    turn = _turn(omega, decay, start, duration)
    if turn > 0.0:
        count = _behind_play(joint, omega, decay, start, 0.0, turn, stretches, count)
    if duration > turn:
        count = _behind_play(joint, omega, decay, start, turn, duration, stretches, count)
    if jump != 0.0 and joint.contact == 1.0:  # the motor's own end stop
        theta = joint.motor + way(omega, decay, start, duration) - joint.ahead
        count = _add(stretches, count, 0.0, 0.0, 0.0, 0.0, jump, theta, -jump)
    return count


@compiled
def _strikes(joint: Record, decay: float, start: float, duration: float) -> tuple[float, float, float]:
    """The motor's first impact on an end stop in a stretch: when, where, and its velocity then; else the stretch's
    duration and no velocity."""
    theta, omega = joint.motor, joint.rate
    turn = _turn(omega, decay, start, duration)
    before = 0.0
    for after in (turn, duration):
        there = theta + way(omega, decay, start, after)
        if joint.lowest <= there <= joint.highest:
            before = after
            continue
        stop, side = (joint.highest, 1.0) if there > joint.highest else (joint.lowest, -1.0)
        instant = _reaches(omega, decay, start, stop - theta, side, before, after)
        return instant, stop, omega + start * risen(decay, instant)
    return duration, theta, 0.0


@inlined
def _move(
    joint: Record, duration: float, decay: float, start: float, stretches: Record, count: int
) -> tuple[float, int]:
    """Move the motor under theta'' = start exp(-decay t), or to its first impact on an end stop: the time used, and how
    many stretches there are."""
    most = (abs(joint.rate) + abs(start) * duration) * duration
    if joint.motor - most < joint.lowest or joint.motor + most > joint.highest:
        instant, stop, velocity = _strikes(joint, decay, start, duration)
        if velocity != 0.0:
            end = start * np.exp(-decay * instant)
            count = _link(joint, instant, decay, start, end, -velocity, stretches, count)
            joint.motor, joint.rate, joint.acceleration = stop, 0.0, 0.0
            return instant, count
    if decay == 0.0:
        lasted, end = duration, start
        passed = duration * (joint.rate + 0.5 * start * duration)
    else:
        lasted = (
            joint.late_risen if duration == joint.late
            else joint.early_risen if duration == joint.early
            else risen(decay, duration)
        )  # fmt: skip
        end = start * (1.0 - decay * lasted)
        passed = joint.rate * duration + start / decay * (duration - lasted)
    count = _link(joint, duration, decay, start, end, 0.0, stretches, count)
    joint.motor = min(max(joint.motor + passed, joint.lowest), joint.highest)
    joint.rate += start * lasted
    joint.acceleration = end
    return duration, count


@inlined
def hold(joint: Record, span: float, target: float, stretches: Record, count: int) -> int:
    """Move for `span` s towards the constant velocity `target`, rad/s; returns how many stretches there are now."""
    linear = joint.most / joint.decay
    while span > 0.0 and count < _MOST_STRETCHES:
        omega = joint.rate
        if omega == 0.0 and (
            (joint.motor >= joint.highest and target >= 0.0)
            or (joint.motor <= joint.lowest and target <= 0.0)
        ):
            joint.acceleration = 0.0
            return _link(joint, span, 0.0, 0.0, 0.0, 0.0, stretches, count)
        error = target - omega
        excess = abs(error) - linear
        # what rounding leaves of an excess must not count as one, or the loop would never end
        if excess > 1e-12 * (linear + abs(target) + abs(omega)):
            start = joint.most if error > 0.0 else -joint.most
            used, count = _move(joint, min(span, excess / joint.most), 0.0, start, stretches, count)
        else:
            used, count = _move(joint, span, joint.decay, joint.decay * error, stretches, count)
        span -= used
    return count
