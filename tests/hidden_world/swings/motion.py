"""The motion: every mode in closed form from grid point to grid point, under a force that is linear between them.

With s = -z w + i w sqrt(1 - z^2), q'' + 2 z w q' + w^2 q = f has q = Im(y) / Im(s) where y' = s y + f. Over one step h
of a force that goes straight from f0 to f1

    y(h) = e^(s h) y(0) + (p - r) f0 + r f1,    p = (e^(s h) - 1) / s,    r = (e^(s h) - 1 - s h) / (s^2 h)

The joint's speed follows its command as a first-order lag; commands hold for a cycle.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from tests.hidden_world.swings.rig import STEP_S, TICK_S, Case, Event, Mode

Values = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """On the grid, shape (steps + 1,): time_s, theta_rad, speed_rad_s, deflection_m, tip_m (of all that moves it),
    acceleration_m_s2 of the tip. command_rad_s: a value a cycle."""

    time_s: Values
    theta_rad: Values
    speed_rad_s: Values
    deflection_m: Values
    tip_m: Values
    acceleration_m_s2: Values
    command_rad_s: Values


def move(case: Case) -> Motion:
    """What the arm does."""
    steps = round(case.duration_s / STEP_S)
    time_s = np.arange(steps + 1) * STEP_S
    command = _command(case)
    theta, speed, before, after = _joint(case, command, steps)
    force_after, force_before = force(case, time_s)
    deflection, bends = np.zeros(steps + 1), np.zeros(steps + 1)
    for number, mode in enumerate(case.modes):
        start = case.swinging_m if number == 0 else 0.0
        f0 = mode.push * force_after - mode.participation * case.length_m * after
        f1 = mode.push * force_before - mode.participation * case.length_m * before
        q, second = _mode(
            mode, f0, f1, start, np.random.default_rng((case.seed, 21)).uniform(0.0, 2.0 * np.pi)
        )
        deflection += q
        bends += second
    return Motion(
        time_s,
        theta,
        speed,
        deflection,
        case.length_m * theta + deflection,
        case.length_m * after + bends,
        command,
    )


def _mode(mode: Mode, f0: Values, f1: Values, amplitude_m: float, phase: float) -> tuple[Values, Values]:
    """Deflection and its second derivative. f0, f1: the force just after and just before each grid point."""
    w, z = 2.0 * np.pi * mode.frequency_hz, mode.damping_ratio
    s = complex(-z * w, w * np.sqrt(1.0 - z * z))
    turn = np.exp(s * STEP_S)
    p, r = (turn - 1.0) / s, (turn - 1.0 - s * STEP_S) / (s * s * STEP_S)
    drive = np.zeros(len(f0), dtype=complex)
    drive[0] = amplitude_m * s.imag * np.exp(1j * phase)
    drive[1:] = (p - r) * f0[:-1] + r * f1[1:]
    y = lfilter([1.0], [1.0, -turn], drive)
    return np.imag(y) / s.imag, np.imag(s * s * y) / s.imag + f0


def _joint(case: Case, command: Values, steps: int) -> tuple[Values, Values, Values, Values]:
    """Angle, speed, and acceleration just before and just after each grid point."""
    held = np.repeat(command, round(TICK_S / STEP_S))[:steps]
    late = round(case.joint.dead_time_s / STEP_S)
    held = np.concatenate((np.zeros(late), held))[:steps]
    lag = 2.0 * np.pi * case.joint.bandwidth_hz
    keep = np.exp(-lag * STEP_S)
    speed = np.concatenate(([0.0], lfilter([1.0 - keep], [1.0, -keep], held)))
    theta = np.concatenate(([0.0], np.cumsum(held * STEP_S - np.diff(speed) / lag)))
    after = np.append(lag * (held - speed[:-1]), 0.0)
    before = np.concatenate(([0.0], lag * (held - speed[1:])))
    return theta, speed, before, after


def _command(case: Case) -> Values:
    """A rest-to-rest move has the speed size / ramp (1 - cos(2 pi t / ramp))."""
    time_s = np.arange(round(case.duration_s / TICK_S)) * TICK_S
    command = np.zeros(len(time_s))
    for event in case.events:
        if event.kind == "move":
            x = (time_s - event.at_s) / event.ramp_s
            inside = (x >= 0.0) & (x < 1.0)
            command += np.where(inside, event.size / event.ramp_s * (1.0 - np.cos(2.0 * np.pi * x)), 0.0)
    return command


def force(case: Case, time_s: Values) -> tuple[Values, Values]:
    """Force at the tip per modal mass, m/s^2, just after and just before each grid point."""
    after, before = np.zeros(len(time_s)), np.zeros(len(time_s))
    w = 2.0 * np.pi * case.modes[0].frequency_hz
    for number, event in enumerate(case.events):
        if event.kind == "move":
            continue
        first = max(0, round(event.at_s / STEP_S))
        last = min(len(time_s) - 1, round((event.end_s) / STEP_S))
        if event.kind == "strike" and event.ramp_s == 0.0:  # all of it within one step
            after[first] += event.size * w / STEP_S
            before[first + 1] += event.size * w / STEP_S
            continue
        part = slice(first, last + 1)
        t = time_s[part] - first * STEP_S
        luck = np.random.default_rng((case.seed, 22, number))
        shape = _shape(event, t, w, luck)
        after[part] += shape
        before[part] += shape
        if event.kind == "pull":  # let go from one instant to the next
            gone = round((event.ramp_s + event.hold_s) / STEP_S)
            if gone < len(t):
                before[first + gone] += event.size * w * w * _wobble(event, t, luck)[gone]
    return after, before


def _shape(event: Event, t: Values, w: float, luck: np.random.Generator) -> Values:
    if event.kind == "strike":
        impact = np.pi / 2.0 / event.ramp_s * np.sin(np.pi * t / event.ramp_s)
        return np.where(t <= event.ramp_s, event.size * w * impact, 0.0)
    if event.kind == "push":
        return np.where(t <= event.ramp_s, event.size * w * w * np.sin(np.pi * t / event.ramp_s), 0.0)
    if event.kind == "rock":
        grown = np.minimum(1.0, np.minimum(t, event.hold_s - t) / (0.1 * event.hold_s))
        wave = 2.0 * w * event.size / event.hold_s * np.sin(event.ratio * w * t)
        return np.where(t <= event.hold_s, grown * wave, 0.0)
    x = np.clip(t / event.ramp_s, 0.0, 1.0)
    held = np.where(t < event.ramp_s + event.hold_s - 0.5 * STEP_S, 1.0, 0.0)
    return np.asarray(event.size * w * w * x * x * (3.0 - 2.0 * x) * held * _wobble(event, t, luck))


def _wobble(event: Event, t: Values, luck: np.random.Generator) -> Values:
    """A hand does not hold still: two slow sines of a few per cent, the same at every call."""
    luck = np.random.default_rng(luck.bit_generator.seed_seq)  # type: ignore[attr-defined]
    out = np.ones(len(t))
    for _ in range(2):
        size, hertz, phase = luck.uniform(0.0, 0.03), luck.uniform(0.3, 2.5), luck.uniform(0.0, 6.28)
        out += size * (np.sin(2.0 * np.pi * hertz * t + phase) - np.sin(phase))
    return out
