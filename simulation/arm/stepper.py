"""One cycle of the arm, compiled: every simulation in the program moves by this function.

    q_i'' + 2 zeta_i w_i q_i' + w_i^2 q_i = - participation_i length theta'' + force_i
    s = length theta + sum q_i

The joint's motion comes as stretches (joint.py), in each of which theta'' = start exp(-decay t). Over a stretch the
linear part of a mode is solved exactly (`_linear`), for any frequency and duration: a second mode of 400 Hz asks for no
shorter step. Laws of causes come in by address (compiled_laws.py). If a law acts on a mode, its deviation from
the linear part is integrated by the classical Runge-Kutta method of fourth order in the frame that moves with the
linear solution (Lawson, 1967), in steps of so many radians at most, broken where the rate of the first mode passes
through zero, if a law has a corner there, and at the laws' onsets. Forward sensitivities would move
beside the state in `_kicked`: the laws are differentiable between those breaks.
"""

import numpy as np
from numpy.typing import NDArray

from stillarm.simulation.arm.compiled_laws import frequency_law, state_law
from stillarm.simulation.arm.compiler import compiled, inlined, nth
from stillarm.simulation.arm.joint import hold, risen, way
from stillarm.simulation.arm.state import Record, Records

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Transition = tuple[float, float, float, float]
"""[[a, b], [c, d]] of (q, v), as a, b, c, d."""

_FORCE, _FRICTION, _FREQUENCY = 0, 1, 2  # state.FORCE and its like: numba takes plain numbers of this module
_TURN_OF_DRIFT = 0.5  # rad of a mode in a step where only its frequency changes, by a millionth in a step
_BISECTIONS = 50
_MOST_PIECES = 64  # of a stretch: more would be rounding errors chasing each other
_LEAST_RATIO = 0.01  # of a frequency: an arm that has lost its stiffness is no longer one
_INSIDE = 1e-9  # of a step: at its ends a law is asked just inside it, as it may jump there


@compiled
def tune(arm: Record, mode: Record, w: float) -> None:
    """Let a mode vibrate at another angular frequency from now on; damping ratio, deflection and rate stay."""
    zeta, decay = mode.zeta, arm.decay
    mode.w, mode.sigma, mode.stiffness = w, zeta * w, w * w
    mode.damped = w * np.sqrt((1.0 - zeta) * (1.0 + zeta))
    mode.static = -mode.push / (w * w)
    mode.lagged = -mode.push / (decay * decay - 2.0 * zeta * w * decay + w * w)  # no zero, as zeta < 1
    mode.one.h = mode.other.h = 0.0


@compiled
def _worked_out(arm: Record, mode: Record, h: float) -> Record:
    """Store a duration's step in place of the older stored one."""
    step = mode.one if mode.replaced == 0 else mode.other
    mode.replaced = 1 - mode.replaced
    half = 0.5 * h
    step.h, step.fade = h, np.exp(-arm.decay * half)
    step.a, step.b, step.c, step.d = transition(mode, half)
    step.wa, step.wb, step.wc, step.wd = transition(mode, h)
    return step


@inlined
def _step(arm: Record, mode: Record, h: float) -> Record:
    """The step of a mode over a duration; two durations are stored."""
    if mode.one.h == h:
        return mode.one
    if mode.other.h == h:
        return mode.other
    return _worked_out(arm, mode, h)


@compiled
def transition(mode: Record, duration: float) -> Transition:
    """How the free mode, once tuned, goes on over a duration."""
    shrink = np.exp(-mode.sigma * duration)
    cosine = shrink * np.cos(mode.damped * duration)
    sine = shrink * np.sin(mode.damped * duration) / mode.damped
    return cosine + mode.sigma * sine, sine, -mode.stiffness * sine, cosine - mode.sigma * sine


@inlined
def _linear(
    mode: Record, q: float, v: float, decay: float, start: float, end: float, turn: Transition
) -> tuple[float, float]:
    """A mode after a time in which theta'' goes from `start` to `end`: its particular solution, and free about that."""
    gain = mode.static if decay == 0.0 else mode.lagged
    pushed = mode.force / mode.stiffness
    x, y = q - gain * start - pushed, v + decay * gain * start
    a, b, c, d = turn
    return a * x + b * y + gain * end + pushed, c * x + d * y - decay * gain * end


@inlined
def undisturbed(
    arm: Record, mode: Record, q: float, v: float, duration: float, start: float, end: float
) -> tuple[float, float]:
    """A mode after a duration in which theta'' decays with the drive's lag from `start` to `end`."""
    step = _step(arm, mode, duration)
    return _linear(mode, q, v, arm.decay, start, end, (step.wa, step.wb, step.wc, step.wd))


@inlined
def ratio_at(arm: Record, i: int, t: float) -> float:
    """A mode's frequency over the declared one at a time from the recording's start. A law counts time from when it
    begins to act: what drifts has not drifted by then."""
    ratio = 1.0
    if arm.changes == 0:
        return ratio
    for row in range(arm.laws):
        law = nth(arm.law, row)
        if law.site == _FREQUENCY and t >= law.begin:
            ratio *= frequency_law(law, max(t - law.begin, 0.0), float(i), arm.mode.hz)
    return max(ratio, _LEAST_RATIO)


@inlined
def jumped(
    q: float, v: float, i: int, k: int, next_jump: int, jump_cycles: Integers, jumps: Array
) -> tuple[float, float, int]:
    """Mode number i with its jumps at the start of cycle k, and the number of the next one. jump_cycles: (j,)
    ascending; jumps: (j, m, 2) of q_i and q_i'."""
    while next_jump < len(jump_cycles) and jump_cycles[next_jump] <= k:
        q += jumps[next_jump, i, 0]
        v += jumps[next_jump, i, 1]
        next_jump += 1
    return q, v, next_jump


@compiled
def strike(arms: Records, i: int, t: float, deflection: float) -> None:
    """An impact on a mode, after which it rings with amplitude `deflection`, m: its rate jumps by w times that."""
    mode = nth(arms[0].mode, i)
    mode.v += 2.0 * np.pi * mode.hz * ratio_at(arms[0], i, t) * deflection


@inlined
def pushed(
    arm: Record, t: float, theta: float, omega: float, q: float, v: float, w: float
) -> tuple[float, float]:
    """Acceleration of the first mode by the laws of force, and the largest friction, m/s^2."""
    push, rub, since = 0.0, 0.0, max(t, 0.0)
    for row in range(arm.laws):
        law = nth(arm.law, row)
        if since < law.begin:
            continue
        if law.site == _FORCE:
            push += state_law(law, since, theta, omega, q, v, w)
        elif law.site == _FRICTION:
            rub += state_law(law, since, theta, omega, q, v, w)
    return push, rub


@inlined
def _deviation(
    arm: Record, i: int, t: float, x: float, theta: float, omega: float,
    q: float, v: float, ratio: float,
) -> tuple[float, float]:  # fmt: skip
    """q'' beyond the linear equation of the tuned mode, without friction, and the largest friction, m/s^2. x: s from
    the cycle's start."""
    mode = nth(arm.mode, i)
    w0, w, extra, rub = mode.w, mode.w, 0.0, 0.0
    if arm.changes != 0:
        w = 2.0 * np.pi * mode.hz * ratio
        extra = -2.0 * mode.zeta * (w - w0) * v - (w * w - w0 * w0) * q
    if i == 0:
        extra += arm.c0 + x * (arm.c1 + x * arm.c2)
        if arm.pushes != 0:
            push, rub = pushed(arm, t, theta, omega, q, v, w)
            extra += push
    return extra, rub


@compiled
def _kicked(
    arm: Record, i: int, t: float, x: float, at: float, h: float,
    stretch: Record, q: float, v: float, direction: float,
) -> tuple[float, float]:  # fmt: skip
    """Advance a mode by h under all that acts, from time `at` of the stretch: one step of Lawson's fourth-order method.

    t: from the recording's start, x: from the cycle's, both at the step's beginning, s.
    """
    mode, decay, half = nth(arm.mode, i), stretch.decay, 0.5 * h
    step = _step(arm, mode, h)
    start, theta, omega = stretch.start, stretch.theta, stretch.omega
    if at > 0.0:
        theta, omega = theta + way(omega, decay, start, at), omega + start * risen(decay, at)
        start *= np.exp(-decay * at)
    if decay == 0.0:
        middle, end, half_risen, whole_risen = start, start, half, h
        theta_m, theta_e = theta + half * (omega + 0.5 * start * half), theta + h * (omega + 0.5 * start * h)
    else:
        middle, end = start * step.fade, start * step.fade * step.fade
        half_risen, whole_risen = (1.0 - step.fade) / decay, (1.0 - step.fade * step.fade) / decay
        theta_m = theta + omega * half + start / decay * (half - half_risen)
        theta_e = theta + omega * h + start / decay * (h - whole_risen)
    omega_m, omega_e = omega + start * half_risen, omega + start * whole_risen
    r0, r1 = ratio_at(arm, i, t + _INSIDE * h), ratio_at(arm, i, t + half)
    r2 = ratio_at(arm, i, t + h - _INSIDE * h)
    qh, vh = _linear(mode, q, v, decay, start, middle, (step.a, step.b, step.c, step.d))
    qe, ve = _linear(mode, q, v, decay, start, end, (step.wa, step.wb, step.wc, step.wd))
    b, d = step.b, step.d
    push, rub = _deviation(arm, i, t, x, theta, omega, q, v, r0)
    k1 = push - direction * rub
    q2, v2 = qh + half * b * k1, vh + half * d * k1
    push, rub = _deviation(arm, i, t + half, x + half, theta_m, omega_m, q2, v2, r1)
    k2 = push - direction * rub
    push, rub = _deviation(arm, i, t + half, x + half, theta_m, omega_m, qh, vh + half * k2, r1)
    k3 = push - direction * rub
    q4, v4 = qe + h * b * k3, ve + h * d * k3
    push, rub = _deviation(arm, i, t + h, x + h, theta_e, omega_e, q4, v4, r2)
    k4 = push - direction * rub
    both = 2.0 * (k2 + k3)
    return qe + h / 6.0 * (step.wb * k1 + b * both), ve + h / 6.0 * (step.wd * k1 + d * both + k4)


@inlined
def free_acceleration(mode: Record, alpha: float, q: float, v: float) -> float:
    """q'' of a mode on which no law acts, m/s^2. alpha: theta''."""
    free: float = mode.force - mode.push * alpha - 2.0 * mode.sigma * v - mode.stiffness * q
    return free


@inlined
def _second(
    arm: Record, i: int, t: float, x: float, theta: float, omega: float,
    alpha: float, q: float, v: float,
) -> tuple[float, float]:  # fmt: skip
    """q_i'' without friction, and the largest friction, m/s^2."""
    free = free_acceleration(nth(arm.mode, i), alpha, q, v)
    extra, rub = 0.0, 0.0
    if arm.laws > 0 or (i == 0 and _acts(arm)):
        ratio = ratio_at(arm, i, t)
        extra, rub = _deviation(arm, i, t, x, theta, omega, q, v, ratio)
    return free + extra, rub


@compiled
def _pull(
    arm: Record,
    t: float,
    x: float,
    at: float,
    stretch: Record,
    q: float,
    v: float,
) -> tuple[float, float]:
    """The same for the first mode at a time `at` of a stretch."""
    theta = stretch.theta + way(stretch.omega, stretch.decay, stretch.start, at)
    omega = stretch.omega + stretch.start * risen(stretch.decay, at)
    alpha = stretch.start * np.exp(-stretch.decay * at)
    return _second(arm, 0, t + at, x + at, theta, omega, alpha, q, v)


@compiled
def _first_through(
    arm: Record,
    t: float,
    x: float,
    at: float,
    end: float,
    stretch: Record,
    most: float,
) -> None:
    """The first mode through a part of a stretch in steps of at most `most` s, each with one direction of its rate."""
    q, v = arm.mode.q, arm.mode.v
    for _ in range(_MOST_PIECES + int((end - at) / most)):
        if at >= end:
            break
        h = min(most, end - at)
        direction = np.sign(v) if arm.turns != 0 else 0.0
        if v == 0.0 and arm.turns != 0:
            pull, rub = _pull(arm, t, x, at, stretch, q, v)
            direction = np.sign(pull)
            if rub > 0.0 and abs(pull) <= rub:
                at += _held(arm, t, x, at, h, stretch, q)
                continue
        to_q, to_v = _kicked(arm, 0, t + at, x + at, at, h, stretch, q, v, direction)
        if direction * to_v < 0.0:
            h, to_q = _reversal(arm, t, x, at, h, stretch, q, v, to_v, direction)
            to_v = 0.0
        q, v = to_q, to_v
        at += h
    arm.mode.q, arm.mode.v = q, v


@compiled
def _reversal(
    arm: Record, t: float, x: float, at: float, h: float, stretch: Record, q: float, v: float, end_v: float,
    direction: float,
) -> tuple[float, float]:  # fmt: skip
    """When the rate of the first mode passes through zero within a step of h, and where the mode is then: by secants
    that keep it bracketed (the Illinois method), or by halves from a rate of zero on."""
    before, after, low, high, there = 0.0, h, direction * v, direction * end_v, q
    middle, least = h, 1e-15 * abs(v - end_v)
    for _ in range(_BISECTIONS):
        middle = before + (after - before) * (low / (low - high) if low > 0.0 else 0.5)
        there, rate = _kicked(arm, 0, t + at, x + at, at, middle, stretch, q, v, direction)
        rate *= direction
        if abs(rate) <= least or not before < middle < after:
            break
        if rate < 0.0:
            after, high, low = middle, rate, 0.5 * low
        else:
            before, low, high = middle, rate, 0.5 * high
    return middle, there


@compiled
def _held(
    arm: Record,
    t: float,
    x: float,
    at: float,
    h: float,
    stretch: Record,
    q: float,
) -> float:
    """How long friction holds the first mode, s, at most h: as theta'' decays one way in a stretch, the pull does."""
    pull, rub = _pull(arm, t, x, at + h, stretch, q, 0.0)
    if abs(pull) <= rub:
        return h
    before = 0.0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (before + h)
        pull, rub = _pull(arm, t, x, at + middle, stretch, q, 0.0)
        if abs(pull) > rub:
            h = middle
        else:
            before = middle
    return h


@compiled
def _mode_through(
    arm: Record,
    i: int,
    t: float,
    x: float,
    at: float,
    end_at: float,
    stretch: Record,
) -> None:
    """A mode through a part of a stretch in which no law breaks off."""
    h, mode = end_at - at, nth(arm.mode, i)
    middle = ratio_at(arm, i, t + at + 0.5 * h)
    varies = (
        ratio_at(arm, i, t + at + _INSIDE * h) != middle
        or ratio_at(arm, i, t + end_at - _INSIDE * h) != middle
    )
    w = 2.0 * np.pi * mode.hz * middle
    if w != mode.w:
        tune(arm, mode, w)
    if i == 0 and _acts(arm):
        _first_through(arm, t, x, at, end_at, stretch, h / np.ceil(w * h / arm.turn))
    elif varies:
        parts = int(np.ceil(w * h / _TURN_OF_DRIFT))
        for part in range(parts):
            now = at + part * h / parts
            mode.q, mode.v = _kicked(arm, i, t + now, x + now, now, h / parts, stretch, mode.q, mode.v, 0.0)
    else:
        step = _step(arm, mode, h)
        start, end = stretch.start, stretch.end
        if h != stretch.duration:
            start, end = start * np.exp(-stretch.decay * at), start * np.exp(-stretch.decay * end_at)
        turn = (step.wa, step.wb, step.wc, step.wd)
        mode.q, mode.v = _linear(mode, mode.q, mode.v, stretch.decay, start, end, turn)


@inlined
def _acts(arm: Record) -> bool:
    """Whether anything besides its own linear equation acts on the first mode."""
    return bool(arm.pushes != 0 or arm.c0 != 0.0 or arm.c1 != 0.0 or arm.c2 != 0.0)


@inlined
def _freely_through(arm: Record, first: int, stretch: Record) -> None:
    """The modes from number `first` on through a stretch in which only the joint moves them."""
    for i in range(first, arm.modes):
        mode = nth(arm.mode, i)
        if stretch.duration > 0.0:
            step = _step(arm, mode, stretch.duration)
            turn = (step.wa, step.wb, step.wc, step.wd)
            mode.q, mode.v = _linear(mode, mode.q, mode.v, stretch.decay, stretch.start, stretch.end, turn)


@compiled
def by_laws(arm: Record, i: int, t: float, x: float, stretch: Record) -> None:
    """A mode through a stretch under the arm's laws, broken where one of them begins or ends. t: from the recording's
    start, x: from the cycle's, s."""
    at = 0.0
    while at < stretch.duration:
        end = stretch.duration
        for row in range(arm.laws):
            if at < nth(arm.law, row).onset - t < end:
                end = nth(arm.law, row).onset - t
        _mode_through(arm, i, t, x, at, end, stretch)
        at = end


@inlined
def modes_through(arm: Record, t: float, count: int) -> None:
    """All modes through the first `count` stretches, from time t from the recording's start on."""
    for i in range(arm.modes):
        if nth(arm.mode, i).w == 0.0:  # as made
            tune(arm, nth(arm.mode, i), 2.0 * np.pi * nth(arm.mode, i).hz)
    x = 0.0
    acts, changes = _acts(arm), arm.changes != 0
    for k in range(count):
        stretch = nth(arm.stretch, k)
        duration = stretch.duration
        if not changes:
            _freely_through(arm, 1 if acts else 0, stretch)
        if acts or changes:
            for i in range(arm.modes if changes else 1):
                by_laws(arm, i, t, x, stretch)
        t += duration
        x += duration
        if stretch.jump != 0.0:
            for i in range(arm.modes):
                nth(arm.mode, i).v -= nth(arm.mode, i).push * stretch.jump


@inlined
def cycle(arm: Record, t: float, early: float, late: float) -> None:
    """Move on by one cycle, which begins t s after the recording's start (earlier, where t is negative).

    early, late: joint velocity that the drive aims at before and after a command's arrival in the cycle, rad/s.
    """
    count = hold(arm, arm.early, early, 0)
    count = hold(arm, arm.late, late, count)
    modes_through(arm, t, count)


@inlined
def link(arm: Record) -> tuple[float, float, float]:
    """theta, theta' and theta'' of the joint, behind any play. An impact is a jump of theta' and not in theta''."""
    if arm.gap == 0.0 or arm.contact == 1.0:
        return arm.motor - arm.ahead, arm.rate, arm.acceleration
    return arm.motor - arm.ahead, 0.0, 0.0


@inlined
def acceleration(arm: Record, i: int, t: float) -> float:
    """q_i'', m/s^2, from the equations at the present state."""
    theta, omega, alpha = link(arm)
    return acceleration_at(arm, i, t, theta, omega, alpha)


@inlined
def acceleration_at(arm: Record, i: int, t: float, theta: float, omega: float, alpha: float) -> float:
    """q_i'', m/s^2, at the mode's present state and the joint's as given."""
    mode = nth(arm.mode, i)
    if mode.w == 0.0:
        tune(arm, mode, 2.0 * np.pi * mode.hz)
    free, rub = _second(arm, i, t, 0.0, theta, omega, alpha, mode.q, mode.v)
    return free - (rub * np.sign(mode.v) if mode.v != 0.0 else min(max(free, -rub), rub))


@compiled
def look(arms: Records, t: float, seen: Array) -> None:
    """Fill the observable state of an arm: theta, theta', theta'', the motor's angle and rate, then q_i, q_i', q_i'' of
    all modes, in this order, (5 + 3 m,). arms: (1,), as in all that is called from outside."""
    arm = arms[0]
    m = arm.modes
    seen[0], seen[1], seen[2] = link(arm)
    seen[3], seen[4] = arm.motor, arm.rate
    for i in range(m):
        seen[5 + i], seen[5 + m + i] = nth(arm.mode, i).q, nth(arm.mode, i).v
        seen[5 + 2 * m + i] = acceleration(arm, i, t)


@compiled
def advance(arms: Records, t: float, early: float, late: float, seen: Array) -> None:
    """A cycle, and what there is to see at its end."""
    cycle(arms[0], t, early, late)
    look(arms, t + arms[0].early + arms[0].late, seen)
