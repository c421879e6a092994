"""The arm's motion: classical Runge-Kutta in steps of 0.1 ms, split wherever something happens.

Something: a command reaching the drive, an impact, a reversal of the bending or of the joint (dry friction), sticking
and slipping, gear teeth meeting or parting. The instant is bisected to 1e-12 of a step.

    joint      vm' = lag (target - drag(vm) - vm), bounded; the link follows, or hangs on teeth with play:
               link'' = vm' + 2 k (vm - link') + k^2 compression while they touch, and rest in between
    bend 1     q'' = - w^2 r(q) - 2 z w q' - share reach link'' + push - friction
    bend 2     the same, linear
    tip        s = reach link + q1 + q2
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tests.hidden_world.rig import FINE, STEP_S, TICK_S

Array = NDArray[np.float64]

WIDTH = 11
"""State: joint angle, speed; bend 1, rate; bend 2, rate; link angle; hysteresis; creep; drive's own filter;
link's speed."""
COLUMNS = 8
"""Kept: joint angle, speed, bend 1, rate, bend 2, rate, link angle, tip acceleration."""


class Works(NamedTuple):
    """What moves, in numbers for the compiled loop. Zero switches an effect off."""

    reach: float
    w1: float
    z1: float
    p1: float
    w2: float
    z2: float
    p2: float
    lag: float
    top_acceleration: float
    top_speed: float
    soft_top: float = 0.0
    """A lower top speed that is reached softly."""
    soft_power: float = 0.0
    """Sharpness of that knee; zero: a corner."""
    dead_enter: float = 0.0
    dead_leave: float = 0.0
    drag: float = 0.0
    drag_excess: float = 0.0
    drag_speed: float = 1.0
    play: float = 0.0
    teeth_rate: float = 500.0
    """k, 1/s: teeth that meet give way and spring back, critically damped; steady motion is followed without lag."""
    filter_rate: float = 0.0
    lag_skew: float = 0.0
    """By what part the drive follows quicker upwards than downwards."""
    ripple: float = 0.0
    ripple_turns: float = 0.0
    ripple_phase: float = 0.0
    dry: float = 0.0
    dry_excess: float = 0.0
    dry_speed: float = 1.0
    drag2: float = 0.0
    """Quadratic damping, 1/m."""
    drag2_power: float = 2.0
    drag2_speed: float = 1.0
    drag2_skew: float = 0.0
    cubic: float = 0.0
    cubic_soft: float = 0.0
    z2_growth: float = 0.0
    lean: float = 0.0
    """Asymmetry of the stiffness."""
    hysteresis: float = 0.0
    hysteresis_yield: float = 1.0
    creep: float = 0.0
    creep_rate: float = 1.0


@njit(cache=True)
def _between(values: Array, t: float) -> float:
    """Linear interpolation on the fine grid; a single value is a constant."""
    if len(values) == 1:
        return float(values[0])
    x = t / STEP_S
    i = int(x)
    if i >= len(values) - 1:
        return float(values[-1])
    return float(values[i] + (x - i) * (values[i + 1] - values[i]))


@njit(cache=True)
def _shaped(command: float, before: float, m: Works) -> float:
    """What the drive makes of a command: dead band with a memory, top speeds."""
    size = abs(command)
    if m.dead_enter > 0.0:
        edge = m.dead_leave if before == 0.0 else m.dead_enter
        if size < edge:
            return 0.0
    out = min(size, m.top_speed)
    if m.soft_top > 0.0:
        if m.soft_power > 0.0:
            out = out / (1.0 + (out / m.soft_top) ** m.soft_power) ** (1.0 / m.soft_power)
        else:
            out = min(out, m.soft_top)
    return out if command >= 0.0 else -out


@njit(cache=True)
def _free_bend(x: Array, link_acceleration: float, pitch: float, push: float, m: Works) -> float:
    """q1'' without dry friction."""
    w = m.w1 * pitch
    q, v = x[2], x[3]
    soft = m.cubic_soft * q
    r = q + m.cubic * q**3 / (1.0 + soft * soft) + m.creep * (q - x[8]) + m.hysteresis * (x[7] - q)
    if m.lean != 0.0 and q > 0.0:
        r += m.lean * q
    a = -w * w * r - 2.0 * m.z1 * w * v - m.p1 * m.reach * link_acceleration + push
    if m.drag2 != 0.0:
        size = abs(v) ** m.drag2_power * m.drag2_speed ** (2.0 - m.drag2_power)
        a -= m.drag2 * size * (1.0 + m.drag2_skew if v > 0.0 else -1.0 + m.drag2_skew)
    return float(a)


@njit(cache=True)
def _slope(  # noqa: PLR0912 one compiled function, an effect a branch
    x: Array, d: Array, held: float, modes: Array, pitch: float, push: float, m: Works
) -> float:
    """Derivative of the state into d; returns the tip's acceleration. modes: sign of arm slip (0 stuck), of joint
    slip (0 stuck), of the teeth in touch (0 none)."""
    target = held
    if m.ripple != 0.0:
        target *= 1.0 + m.ripple * np.sin(m.ripple_turns * x[0] + m.ripple_phase)
    d[9] = 0.0
    if m.filter_rate > 0.0:
        d[9] = m.filter_rate * (target - x[9])
        target = x[9]
    d[0], d[1] = x[1], 0.0
    if m.drag > 0.0 and modes[1] == 0.0:
        d[0] = 0.0
    else:
        if m.drag > 0.0:
            target -= modes[1] * m.drag * (1.0 + m.drag_excess * np.exp(-abs(x[1]) / m.drag_speed))
        lag = m.lag * (1.0 + m.lag_skew if target > x[1] else 1.0 - m.lag_skew)
        d[1] = min(max(lag * (target - x[1]), -m.top_acceleration), m.top_acceleration)
    d[6], link = d[0], d[1]
    if m.play > 0.0:
        d[6], link = x[10], 0.0
        if modes[2] != 0.0:
            compressed = x[0] - x[6] - modes[2] * 0.5 * m.play
            link = d[1] + 2.0 * m.teeth_rate * (d[0] - x[10]) + m.teeth_rate**2 * compressed
    d[10] = link
    a1 = _free_bend(x, link, pitch, push, m)
    d[2] = x[3]
    if m.dry > 0.0:
        if modes[0] == 0.0:
            a1, d[2] = 0.0, 0.0
        else:
            a1 -= modes[0] * m.dry * (1.0 + m.dry_excess * np.exp(-abs(x[3]) / m.dry_speed))
    d[3] = a1
    a2 = 0.0
    d[4] = x[5]
    if m.w2 > 0.0:
        z = m.z2 * (1.0 + m.z2_growth * abs(x[4]))
        a2 = -m.w2 * m.w2 * x[4] - 2.0 * z * m.w2 * x[5] - m.p2 * m.reach * link
    d[5] = a2
    d[7] = 0.0
    if m.hysteresis > 0.0:
        d[7] = x[3]
        if x[3] * x[7] > 0.0:
            d[7] *= 1.0 - abs(x[7]) / m.hysteresis_yield
    d[8] = m.creep_rate * (x[2] - x[8]) if m.creep != 0.0 else 0.0
    return float(m.reach * link + a1 + a2)


@njit(cache=True)
def _stride(
    x: Array,
    out: Array,
    k: Array,
    t: float,
    h: float,
    held: float,
    modes: Array,
    pitch: Array,
    push: Array,
    m: Works,
) -> None:
    """One Runge-Kutta step of length h from x at t into out. k: scratch, (5, WIDTH)."""
    plain = m.filter_rate == 0.0 and m.play == 0.0 and m.hysteresis == 0.0 and m.creep == 0.0
    width = 7 if plain else WIDTH  # what no effect uses stays as it is
    k[4] = x
    a, b, c = t, t + 0.5 * h, t + h
    fa, fb, fc = _between(pitch, a), _between(pitch, b), _between(pitch, c)
    pa, pb, pc = _between(push, a), _between(push, b), _between(push, c)
    _slope(x, k[0], held, modes, fa, pa, m)
    for i in range(width):
        k[4, i] = x[i] + 0.5 * h * k[0, i]
    _slope(k[4], k[1], held, modes, fb, pb, m)
    for i in range(width):
        k[4, i] = x[i] + 0.5 * h * k[1, i]
    _slope(k[4], k[2], held, modes, fb, pb, m)
    for i in range(width):
        k[4, i] = x[i] + h * k[2, i]
    _slope(k[4], k[3], held, modes, fc, pc, m)
    for i in range(width, WIDTH):
        out[i] = x[i]
    for i in range(width):
        out[i] = x[i] + h / 6.0 * (k[0, i] + 2.0 * k[1, i] + 2.0 * k[2, i] + k[3, i])


@njit(cache=True)
def _margin(  # noqa: PLR0911 one compiled function
    which: int, x: Array, k: Array, t: float, held: float, modes: Array, pitch: Array, push: Array, m: Works
) -> float:
    """How far from an event, below zero beyond it: 0 arm's friction, 1 joint's friction, 2 teeth."""
    if which == 0:
        if m.dry == 0.0:
            return 1.0
        if modes[0] != 0.0:
            return float(modes[0] * x[3])
        _slope(x, k[4], held, modes, 1.0, 0.0, m)
        link = k[4, 10]
        net = _free_bend(x, link, _between(pitch, t), _between(push, t), m)
        return float(m.dry * (1.0 + m.dry_excess) - abs(net))
    if which == 1:
        if m.drag == 0.0:
            return 1.0
        if modes[1] != 0.0:
            return float(modes[1] * x[1])
        target = x[9] if m.filter_rate > 0.0 else held
        return float(m.drag * (1.0 + m.drag_excess) - abs(target))
    if m.play == 0.0:
        return 1.0
    apart = x[0] - x[6]
    if modes[2] == 0.0:
        return float(0.5 * m.play - abs(apart))
    return float(modes[2] * x[1])


@njit(cache=True)
def _turn_over(
    which: int, x: Array, k: Array, t: float, held: float, modes: Array, pitch: Array, push: Array, m: Works
) -> None:
    """What happens at an event."""
    if which == 2:
        if modes[2] == 0.0:
            modes[2] = 1.0 if x[0] > x[6] else -1.0
        else:
            modes[2] = 0.0
            x[10] = 0.0
        return
    was = modes[which]
    x[3 if which == 0 else 1] = 0.0
    modes[which] = 0.0
    if _margin(which, x, k, t, held, modes, pitch, push, m) >= 0.0 and was != 0.0:
        return
    if which == 0:
        _slope(x, k[4], held, modes, 1.0, 0.0, m)
        link = k[4, 10]
        net = _free_bend(x, link, _between(pitch, t), _between(push, t), m)
        modes[0] = 1.0 if net > 0.0 else -1.0
    else:
        target = x[9] if m.filter_rate > 0.0 else held
        modes[1] = 1.0 if target > 0.0 else -1.0


@njit(cache=True)
def _advance(
    x: Array,
    out: Array,
    k: Array,
    t: float,
    end: float,
    held: float,
    modes: Array,
    pitch: Array,
    push: Array,
    m: Works,
) -> None:
    """x from t to end, past every event between."""
    eventful = m.dry > 0.0 or m.drag > 0.0 or m.play > 0.0
    for _ in range(60):
        if eventful:
            for which in range(3):
                if _margin(which, x, k, t, held, modes, pitch, push, m) < 0.0:
                    _turn_over(which, x, k, t, held, modes, pitch, push, m)
        h = end - t
        _stride(x, out, k, t, h, held, modes, pitch, push, m)
        happened = False
        if eventful:
            for which in range(3):
                happened = happened or _margin(which, out, k, end, held, modes, pitch, push, m) < 0.0
        if not happened:
            x[:] = out
            return
        low, high = 0.0, 1.0
        for _ in range(40):
            middle = 0.5 * (low + high)
            _stride(x, out, k, t, middle * h, held, modes, pitch, push, m)
            beyond = False
            for which in range(3):
                beyond = beyond or _margin(which, out, k, t + middle * h, held, modes, pitch, push, m) < 0.0
            if beyond:
                high = middle
            else:
                low = middle
        _stride(x, out, k, t, high * h, held, modes, pitch, push, m)
        x[:] = out
        t += high * h
    _stride(x, out, k, t, end - t, held, modes, pitch, push, m)
    x[:] = out


@njit(cache=True)
def move(
    m: Works,
    start: Array,
    reference: Array,
    hold_up: Array,
    gain: Array,
    guess_error: Array,
    wash_rate: float,
    impact_time: Array,
    impact: Array,
    pitch: Array,
    push: Array,
) -> tuple[Any, Any]:
    """Rows of COLUMNS on the fine grid, and the command of each cycle.

    command_n = reference_n + gain_n * (q + guess_error_n, freed of its slow part at wash_rate 1/s), read at
    n TICK_S and in force from n TICK_S + hold_up_n. blow: jump of the first bend's rate, m/s, at blow_time;
    the second's is the same on a uniform beam (share -0.14), and less where it takes less part.
    """
    cycles = len(reference)
    rows = np.empty((cycles * FINE + 1, COLUMNS))
    command = np.empty(cycles)
    x, out, k, d = start.copy(), np.empty(WIDTH), np.empty((5, WIDTH)), np.empty(WIDTH)
    modes = np.zeros(3)
    held, slow = 0.0, 0.0
    due, struck = 0, 0
    row = 0
    for n in range(cycles):
        seen = x[2] + x[4] + guess_error[n]
        slow += wash_rate * TICK_S * (seen - slow)
        command[n] = reference[n] + gain[n] * (seen - slow)
        for _ in range(FINE):
            t, end = row * STEP_S, (row + 1) * STEP_S
            tip = _slope(x, d, held, modes, _between(pitch, t), _between(push, t), m)
            rows[row, :7] = x[:7]
            rows[row, 7] = tip
            while True:
                stop = end
                command_next = due <= n and due * TICK_S + hold_up[due] < stop - 1e-12
                if command_next:
                    stop = due * TICK_S + hold_up[due]
                impact_next = struck < len(impact) and impact_time[struck] < stop - 1e-12
                if impact_next:
                    stop, command_next = impact_time[struck], False
                if stop > t + 1e-12:
                    _advance(x, out, k, t, stop, held, modes, pitch, push, m)
                    t = stop
                if impact_next:
                    x[3] += impact[struck]
                    x[5] += impact[struck] * min(abs(m.p2) / 0.14, 1.0)
                    if m.dry > 0.0:
                        modes[0] = 1.0 if x[3] > 0.0 else -1.0
                    struck += 1
                elif command_next:
                    held = _shaped(command[due], held, m)
                    due += 1
                else:
                    break
            row += 1
    rows[row, :7] = x[:7]
    rows[row, 7] = _slope(x, d, held, modes, _between(pitch, row * STEP_S), _between(push, row * STEP_S), m)
    return rows, command
