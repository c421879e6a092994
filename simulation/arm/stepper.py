"""One cycle of the arm, compiled: every simulation in the program moves by this function.

    q_i'' + 2 zeta_i w_i q_i' + w_i^2 q_i = - participation_i length theta'' + force_i
    s = length theta + sum q_i

The joint's motion comes as stretches (joint.py), in each of which theta'' = start exp(-decay t). Over a stretch the
linear part of a mode is solved exactly (`_linear`), for any frequency and duration: a second mode of 400 Hz asks for no
shorter step. Laws of causes come in by address (compiled_laws.py). Where any acts on a mode, its deviation from
the linear part is integrated by the classical Runge-Kutta method of fourth order in the frame that moves with the
linear solution (Lawson, 1967), in steps of at most _MOST_TURN radians, broken where the rate of the first mode passes
through zero (dry friction and drag have a corner there) and at the laws' onsets. Forward sensitivities would move
beside the state in `_kicked`: the laws are differentiable between those breaks.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from simulation.arm.compiled_laws import Laws, frequency_law, state_law
from simulation.arm.joint import MOST_STRETCHES, D, J, S, hold, risen, way

Array = NDArray[np.float64]

_MOST_TURN = (
    0.0085  # rad of the first mode in a step of the laws: their error is then below 1e-9 of the amplitude
)
_MOST_TURN_OF_DRIFT = 0.5  # the same where only a frequency changes, by a millionth in a step
_BISECTIONS = 50
_MOST_PIECES = 64  # of a stretch: more would be rounding errors chasing each other
_LEAST_RATIO = 0.01  # of a frequency: an arm that has lost its stiffness is no longer one
_INSIDE = 1e-9  # of a step: at its ends a law is asked just inside it, as it may jump there


class Arm(NamedTuple):
    """All that a cycle needs, as arrays. m: number of modes.

    joint: state, by J. drive: constants, by D. modes: (m, 3) frequency, Hz, damping ratio, participation times length,
    m. shape: (m, 2) q_i, m, and q_i', m/s. forces: (m,) acceleration of each mode held over a cycle, m/s^2. outside:
    (3,) a further one on the first mode, c0 + c1 x + c2 x^2 with x in s from the cycle's start. tuned, table,
    stretches: room for work.
    """

    joint: Array
    drive: Array
    modes: Array
    shape: Array
    forces: Array
    outside: Array
    laws: Laws
    tuned: Array
    table: Array
    stretches: Array


def make_arm(drive: Array, modes: Array, laws: Laws) -> Arm:
    """An arm at rest at joint position zero, or at the end stop nearest to it. drive, modes: see Arm."""
    m = len(modes)
    joint = np.zeros(J.SIZE)
    joint[J.MOTOR] = min(max(0.0, drive[D.LOWEST]), drive[D.HIGHEST])
    arm = Arm(
        joint, drive, modes, np.zeros((m, 2)), np.zeros(m), np.zeros(3), laws,
        np.zeros((m, 6)), np.zeros((2, m, 4)), np.zeros((MOST_STRETCHES, S.SIZE)),
    )  # fmt: skip
    for i in range(m):
        tune(arm, i, 2.0 * np.pi * modes[i, 0])
    return arm


@njit(cache=True, nogil=True, error_model="numpy")
def tune(arm: Arm, i: int, w: float) -> None:
    """Let a mode vibrate at another angular frequency from now on; damping ratio, deflection and rate stay."""
    zeta, push, decay = arm.modes[i, 1], arm.modes[i, 2], arm.drive[0]
    arm.tuned[i, 0], arm.tuned[i, 1] = w, zeta * w
    arm.tuned[i, 2], arm.tuned[i, 3] = w * np.sqrt((1.0 - zeta) * (1.0 + zeta)), w * w
    # how the mode follows a constant theta'' and one that decays with the drive's lag; zeta < 1: no zero below
    arm.tuned[i, 4], arm.tuned[i, 5] = (
        -push / (w * w),
        -push / (decay * decay - 2.0 * zeta * w * decay + w * w),
    )
    for late in range(2):
        arm.table[late, i] = _transition(arm, i, arm.drive[5 + late])


@njit(cache=True, nogil=True, error_model="numpy")
def _transition(arm: Arm, i: int, duration: float) -> tuple[float, float, float, float]:
    """The free mode's transition matrix [[a, b], [c, d]] of (q, q') over a duration."""
    sigma, damped, stiffness = arm.tuned[i, 1], arm.tuned[i, 2], arm.tuned[i, 3]
    shrink = np.exp(-sigma * duration)
    cosine, sine = shrink * np.cos(damped * duration), shrink * np.sin(damped * duration) / damped
    return cosine + sigma * sine, sine, -stiffness * sine, cosine - sigma * sine


@njit(cache=True, nogil=True, error_model="numpy")
def _usual_transition(arm: Arm, i: int, duration: float) -> tuple[float, float, float, float]:
    """The same, remembered for the two durations that nearly every stretch has."""
    for late in range(2):
        if duration == arm.drive[5 + late]:
            row = arm.table[late, i]
            return row[0], row[1], row[2], row[3]
    return _transition(arm, i, duration)


@njit(cache=True, nogil=True, error_model="numpy")
def _linear(
    arm: Arm, i: int, q: float, v: float, decay: float, start: float, end: float,
    turn: tuple[float, float, float, float],
) -> tuple[float, float]:  # fmt: skip
    """A mode after a time in which theta'' goes from `start` to `end`: its particular solution, and free about that."""
    gain = arm.tuned[i, 4] if decay == 0.0 else arm.tuned[i, 5]
    pushed = arm.forces[i] / arm.tuned[i, 3]
    x, y = q - gain * start - pushed, v + decay * gain * start
    a, b, c, d = turn
    return a * x + b * y + gain * end + pushed, c * x + d * y - decay * gain * end


@njit(cache=True, nogil=True, error_model="numpy")
def _ratio(arm: Arm, i: int, t: float) -> float:
    """A mode's frequency over the declared one at a time from the recording's start."""
    ratio = 1.0
    for row in range(arm.laws.table.shape[0]):
        if arm.laws.table[row, 1] == 2:
            ratio *= frequency_law(arm.laws, row, max(t, 0.0), float(i), arm.modes[0, 0])
    return max(ratio, _LEAST_RATIO)


@njit(cache=True, nogil=True, error_model="numpy")
def strike(arm: Arm, i: int, t: float, deflection: float) -> None:
    """A blow on a mode, after which it rings with amplitude `deflection`, m: its rate jumps by w times that."""
    arm.shape[i, 1] += 2.0 * np.pi * arm.modes[i, 0] * _ratio(arm, i, t) * deflection


@njit(cache=True, nogil=True, error_model="numpy")
def _pushed(arm: Arm, site: int, t: float, theta: float, omega: float, q: float, v: float, w: float) -> float:
    """What all laws of a site give the first mode, m/s^2."""
    total = 0.0
    for row in range(arm.laws.table.shape[0]):
        if arm.laws.table[row, 1] == site:
            total += state_law(arm.laws, row, max(t, 0.0), theta, omega, q, v, w)
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _deviation(
    arm: Arm, i: int, t: float, x: float, theta: float, omega: float, q: float, v: float, ratio: float,
    direction: float,
) -> float:  # fmt: skip
    """q'' beyond the linear equation of the tuned mode, m/s^2. x: s from the cycle's start. direction: of the rate, for
    friction to act against; 0: no friction."""
    w0, w = arm.tuned[i, 0], 2.0 * np.pi * arm.modes[i, 0] * ratio
    extra = -2.0 * arm.modes[i, 1] * (w - w0) * v - (w * w - w0 * w0) * q if w != w0 else 0.0
    if i == 0:
        extra += arm.outside[0] + x * (arm.outside[1] + x * arm.outside[2])
        extra += _pushed(arm, 0, t, theta, omega, q, v, w)
        if direction != 0.0:
            extra -= direction * _pushed(arm, 1, t, theta, omega, q, v, w)
    return extra


@njit(cache=True, nogil=True, error_model="numpy")
def _kicked(
    arm: Arm, i: int, t: float, x: float, at: float, h: float, stretch: Array, q: float, v: float,
    direction: float,
) -> tuple[float, float]:  # fmt: skip
    """A mode on by h under all that acts, from time `at` of the stretch: one step of Lawson's fourth-order method.

    t: from the recording's start, x: from the cycle's, both at the step's beginning, s.
    """
    decay, half = stretch[1], 0.5 * h
    start = stretch[2] * np.exp(-decay * at)
    middle, end = start * np.exp(-decay * half), start * np.exp(-decay * h)
    theta, omega = (
        stretch[4] + way(stretch[5], decay, stretch[2], at),
        stretch[5] + stretch[2] * risen(decay, at),
    )
    theta_m, omega_m = theta + way(omega, decay, start, half), omega + start * risen(decay, half)
    theta_e, omega_e = theta + way(omega, decay, start, h), omega + start * risen(decay, h)
    r0, r1, r2 = (
        _ratio(arm, i, t + _INSIDE * h),
        _ratio(arm, i, t + half),
        _ratio(arm, i, t + h - _INSIDE * h),
    )
    turn, whole = _transition(arm, i, half), _transition(arm, i, h)
    qh, vh = _linear(arm, i, q, v, decay, start, middle, turn)
    qe, ve = _linear(arm, i, q, v, decay, start, end, whole)
    b, d = turn[1], turn[3]
    k1 = _deviation(arm, i, t, x, theta, omega, q, v, r0, direction)
    k2 = _deviation(
        arm, i, t + half, x + half, theta_m, omega_m, qh + half * b * k1, vh + half * d * k1, r1, direction
    )
    k3 = _deviation(arm, i, t + half, x + half, theta_m, omega_m, qh, vh + half * k2, r1, direction)
    k4 = _deviation(arm, i, t + h, x + h, theta_e, omega_e, qe + h * b * k3, ve + h * d * k3, r2, direction)
    both = 2.0 * (k2 + k3)
    return qe + h / 6.0 * (whole[1] * k1 + b * both), ve + h / 6.0 * (whole[3] * k1 + d * both + k4)


@njit(cache=True, nogil=True, error_model="numpy")
def _pull(arm: Arm, t: float, x: float, at: float, stretch: Array, q: float, v: float) -> tuple[float, float]:
    """What the first mode's q'' would be without friction, and the largest friction against it, m/s^2."""
    theta = stretch[4] + way(stretch[5], stretch[1], stretch[2], at)
    omega = stretch[5] + stretch[2] * risen(stretch[1], at)
    return _second(arm, 0, t, x, theta, omega, stretch[2] * np.exp(-stretch[1] * at), q, v)


@njit(cache=True, nogil=True, error_model="numpy")
def _second(
    arm: Arm, i: int, t: float, x: float, theta: float, omega: float, alpha: float, q: float, v: float
) -> tuple[float, float]:
    """q_i'' without friction, and the largest friction, m/s^2."""
    ratio = _ratio(arm, i, t)
    w = arm.tuned[i, 0]
    linear = arm.forces[i] - arm.modes[i, 2] * alpha - 2.0 * arm.modes[i, 1] * w * v - w * w * q
    rub = 0.0
    if i == 0:
        rub = _pushed(arm, 1, t, theta, omega, q, v, 2.0 * np.pi * arm.modes[0, 0] * ratio)
    return linear + _deviation(arm, i, t, x, theta, omega, q, v, ratio, 0.0), rub


@njit(cache=True, nogil=True, error_model="numpy")
def _first_through(arm: Arm, t: float, x: float, at: float, end: float, stretch: Array, most: float) -> None:
    """The first mode through a part of a stretch in steps of at most `most` s, each with one direction of its rate."""
    q, v = arm.shape[0]
    for _ in range(_MOST_PIECES + int((end - at) / most)):
        if at >= end:
            break
        h = min(most, end - at)
        direction = np.sign(v)
        if v == 0.0:
            pull, rub = _pull(arm, t + at, x + at, at, stretch, q, v)
            direction = np.sign(pull)
            if rub > 0.0 and abs(pull) <= rub:
                later, holds = _pull(arm, t + at + h, x + at + h, at + h, stretch, q, v)
                if abs(later) > holds:  # theta'' decays one way within a stretch, and so does the pull
                    before = 0.0
                    for _ in range(_BISECTIONS):
                        middle = 0.5 * (before + h)
                        later, holds = _pull(
                            arm, t + at + middle, x + at + middle, at + middle, stretch, q, v
                        )
                        if abs(later) > holds:
                            h = middle
                        else:
                            before = middle
                at += h
                continue
        to_q, to_v = _kicked(arm, 0, t + at, x + at, at, h, stretch, q, v, direction)
        if direction * to_v < 0.0:
            before = 0.0
            for _ in range(_BISECTIONS):
                middle = 0.5 * (before + h)
                to_q, to_v = _kicked(arm, 0, t + at, x + at, at, middle, stretch, q, v, direction)
                if direction * to_v < 0.0:
                    h = middle
                else:
                    before = middle
            to_q, to_v = _kicked(arm, 0, t + at, x + at, at, h, stretch, q, v, direction)
            to_v = 0.0
        q, v = to_q, to_v
        at += h
    arm.shape[0, 0], arm.shape[0, 1] = q, v


@njit(cache=True, nogil=True, error_model="numpy")
def _mode_through(arm: Arm, i: int, t: float, x: float, at: float, end: float, stretch: Array) -> None:
    """A mode through a part of a stretch in which no law breaks off."""
    h = end - at
    middle = _ratio(arm, i, t + at + 0.5 * h)
    varies = _ratio(arm, i, t + at + _INSIDE * h) != middle or _ratio(arm, i, t + end - _INSIDE * h) != middle
    w = 2.0 * np.pi * arm.modes[i, 0] * middle
    if w != arm.tuned[i, 0]:
        tune(arm, i, w)
    if i == 0 and _acts(arm):
        parts = np.ceil(w * h / _MOST_TURN)
        _first_through(arm, t, x, at, end, stretch, h / parts)
        return
    q, v = arm.shape[i]
    if varies:
        parts = int(np.ceil(w * h / _MOST_TURN_OF_DRIFT))
        for part in range(parts):
            now = at + part * h / parts
            q, v = _kicked(arm, i, t + now, x + now, now, h / parts, stretch, q, v, 0.0)
    else:
        decay = stretch[1]
        start = stretch[2] * np.exp(-decay * at) if at > 0.0 else stretch[2]
        turn = _usual_transition(arm, i, h)
        q, v = _linear(arm, i, q, v, decay, start, start * np.exp(-decay * h), turn)
    arm.shape[i, 0], arm.shape[i, 1] = q, v


@njit(cache=True, nogil=True, error_model="numpy")
def _acts(arm: Arm) -> bool:
    """Whether anything but its own linear equation acts on the first mode."""
    for row in range(arm.laws.table.shape[0]):
        if arm.laws.table[row, 1] != 2:
            return True
    return bool(arm.outside[0] != 0.0 or arm.outside[1] != 0.0 or arm.outside[2] != 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def modes_through(arm: Arm, t: float, count: int) -> None:
    """All modes through the first `count` stretches, from time t from the recording's start on."""
    x = 0.0
    for k in range(count):
        stretch = arm.stretches[k]
        duration, at = stretch[0], 0.0
        while at < duration:
            end = duration
            for onset in arm.laws.onsets:
                if at < onset - t < end:
                    end = onset - t
            for i in range(arm.modes.shape[0]):
                _mode_through(arm, i, t, x, at, end, stretch)
            at = end
        t += duration
        x += duration
        if stretch[3] != 0.0:
            for i in range(arm.modes.shape[0]):
                arm.shape[i, 1] -= arm.modes[i, 2] * stretch[3]


@njit(cache=True, nogil=True, error_model="numpy")
def cycle(arm: Arm, t: float, early: float, late: float) -> None:
    """Move on by one cycle, which begins t s after the recording's start (earlier, where t is negative).

    early, late: joint velocity that the drive aims at before and after a command's arrival in the cycle, rad/s.
    """
    count = 0
    if arm.drive[5] > 0.0:
        count = hold(arm.joint, arm.drive, arm.drive[5], early, arm.stretches, count)
    count = hold(arm.joint, arm.drive, arm.drive[6], late, arm.stretches, count)
    modes_through(arm, t, count)


@njit(cache=True, nogil=True, error_model="numpy")
def link(arm: Arm) -> tuple[float, float, float]:
    """theta, theta' and theta'' of the joint, behind any play. An impact is a jump of theta' and not in theta''."""
    joint = arm.joint
    if arm.drive[4] == 0.0 or joint[4] == 1.0:
        return joint[0] - joint[3], joint[1], joint[2]
    return joint[0] - joint[3], 0.0, 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def accelerations(arm: Arm, t: float, out: Array) -> None:
    """Fill q_i'', m/s^2, (m,), from the equations at the present state."""
    theta, omega, alpha = link(arm)
    for i in range(arm.modes.shape[0]):
        q, v = arm.shape[i]
        out[i], rub = _second(arm, i, t, 0.0, theta, omega, alpha, q, v)
        out[i] -= rub * np.sign(v) if v != 0.0 else min(max(out[i], -rub), rub)


@njit(cache=True, nogil=True, error_model="numpy")
def observe(arm: Arm, t: float, seen: Array) -> None:
    """Fill what there is to see of the state: theta, theta', theta'', the motor's angle and rate, then q_i, q_i', q_i''
    of all modes, in this order, (5 + 3 m,)."""
    m = arm.modes.shape[0]
    seen[0], seen[1], seen[2] = link(arm)
    seen[3], seen[4] = arm.joint[0], arm.joint[1]
    seen[5 : 5 + m] = arm.shape[:, 0]
    seen[5 + m : 5 + 2 * m] = arm.shape[:, 1]
    accelerations(arm, t, seen[5 + 2 * m :])


@njit(cache=True, nogil=True, error_model="numpy")
def advance(arm: Arm, t: float, early: float, late: float, seen: Array) -> None:
    """A cycle, and what there is to see at its end."""
    cycle(arm, t, early, late)
    observe(arm, t + arm.drive[5] + arm.drive[6], seen)
