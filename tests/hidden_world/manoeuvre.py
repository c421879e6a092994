"""What is done with an arm in a recording: moves of every kind, rests in which it rings, impacts, damping."""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from tests.hidden_world.rig import TICK_S, Rig

Array = NDArray[np.float64]
_FARTHEST_RAD = 0.5


@dataclass
class Plan:
    """Reference (rad/s) and feedback gain (1/s per m) of each tick; impacts: instants and jumps of the bends' rate."""

    reference: Array
    gain: Array
    impact_time: Array
    impact: Array
    wash_rate: float = 1.5


def plan(rig: Rig, seed: int, duration_s: float, impacts: bool, damped: bool) -> Plan:
    """Moves in random order and of random size; each kind occurs in any 20 s, so that nothing goes unexcited."""
    random = np.random.default_rng((seed, 21))
    ticks = round(duration_s / TICK_S)
    parts: list[Array] = [np.zeros(round(random.uniform(0.3, 0.8) / TICK_S))]
    rests: list[tuple[int, int]] = []
    length, angle = len(parts[0]), 0.0
    while length < ticks:
        for kind in random.permutation(len(_KINDS)):
            part = _KINDS[kind](rig, random)
            if abs(angle + float(np.sum(part)) * TICK_S) > _FARTHEST_RAD:
                part = -part
            rest = np.zeros(round(random.uniform(0.6, 2.2) / TICK_S))
            parts += [part, rest]
            angle += float(np.sum(part)) * TICK_S
            length += len(part) + len(rest)
            rests.append((length - len(rest), length))
    reference = np.concatenate(parts)[:ticks]
    return Plan(
        reference, *_feedback(rig, random, ticks, damped), *_impacts(rig, random, rests, ticks, impacts)
    )


def _feedback(rig: Rig, random: np.random.Generator, ticks: int, damped: bool) -> tuple[Array]:
    """Joint speed proportional to the bending adds share reach gain / (2 w) to the damping ratio."""
    gain = np.zeros(ticks)
    bend = rig.bends[0]
    if damped:
        added = random.uniform(0.03, 0.12)
        on = 2.0 * added * 2.0 * pi * bend.hertz / (bend.share * rig.reach)
        begin = int(ticks * random.uniform(0.1, 0.6))
        gain[begin : begin + int(ticks * random.uniform(0.15, 0.35))] = on
    return (gain,)


def _impacts(
    rig: Rig, random: np.random.Generator, rests: list[tuple[int, int]], ticks: int, wanted: bool
) -> tuple[Array, Array]:
    """An impact early in some of the rests. Always drawn, so that what follows does not depend on it."""
    time, size = [], []
    w = 2.0 * pi * rig.bends[0].hertz
    for begin, end in rests:
        chosen, place, jump = random.random() < 0.3, random.uniform(0.05, 0.4), random.uniform(0.3, 1.0)
        sign = 1.0 if random.random() < 0.5 else -1.0
        at = (begin + place * (end - begin)) * TICK_S
        if wanted and chosen and at < (ticks - 2000) * TICK_S:
            time.append(at)
            size.append(sign * jump * 0.7 * rig.usual_bending * w)
    return np.array(time), np.array(size)


def _trapezoid(speed: float, acceleration: float, distance: float) -> Array:
    """Velocity over time: up, along, down. Signed by speed."""
    peak = min(abs(speed), (acceleration * distance) ** 0.5)
    rise = peak / acceleration
    along = max(distance / peak - rise, 0.0)
    t = np.arange(0.0, 2.0 * rise + along, TICK_S)
    out: Array = np.sign(speed) * np.minimum(np.minimum(t, 2.0 * rise + along - t) * acceleration, peak)
    return out


def _sign(random: np.random.Generator) -> float:
    return 1.0 if random.random() < 0.5 else -1.0


def _fast_move(rig: Rig, random: np.random.Generator) -> Array:
    """Up to nearly the top speed."""
    acceleration = min(rig.root_acceleration(rig.usual_bending * random.uniform(0.8, 1.5)), 12.0)
    speed = rig.joint.top_speed * random.uniform(0.85, 0.98)
    distance = min(speed * speed / acceleration * random.uniform(1.05, 1.4), 0.9 * _FARTHEST_RAD)
    return _trapezoid(_sign(random) * speed, acceleration, distance)


def _move(rig: Rig, random: np.random.Generator) -> Array:
    speed = rig.joint.top_speed * random.uniform(0.2, 0.6)
    acceleration = min(rig.root_acceleration(rig.usual_bending * random.uniform(0.3, 1.0)), 12.0)
    return _trapezoid(_sign(random) * speed, acceleration, random.uniform(0.05, 0.25))


def _steps(rig: Rig, random: np.random.Generator) -> Array:
    """There and back with corners, of several sizes."""
    out = []
    for _ in range(int(random.integers(2, 4))):
        speed = rig.root_step(rig.usual_bending) * random.uniform(0.15, 0.5)
        length = round(random.uniform(0.1, 0.4) / TICK_S)
        out += [np.full(length, speed), np.full(length, -speed)]
    return _sign(random) * np.concatenate(out)


def _chirp(rig: Rig, random: np.random.Generator) -> Array:
    """Small and quick: 0.5 Hz to 12 Hz and over."""
    lasts = random.uniform(2.5, 4.0)
    t = np.arange(0.0, lasts, TICK_S)
    first, last = 0.5, max(random.uniform(9.0, 14.0), 3.0 * rig.bends[0].hertz)
    turn = 2.0 * pi * (first * t + 0.5 * (last - first) * t * t / lasts)
    size = rig.root_step(rig.usual_bending) * random.uniform(0.06, 0.15)
    out: Array = size * np.sin(turn) * np.minimum(1.0, (lasts - t) / 0.2)
    return out


def _many_tones(rig: Rig, random: np.random.Generator) -> Array:
    lasts = random.uniform(2.5, 4.0)
    t = np.arange(0.0, lasts, TICK_S)
    tones = random.uniform(0.3, 15.0, 10)
    out = np.sum(np.sin(2.0 * pi * tones[:, None] * t + random.uniform(0.0, 2.0 * pi, 10)[:, None]), axis=0)
    fade: Array = np.minimum(1.0, np.minimum(t, lasts - t) / 0.3)
    return np.asarray(rig.root_step(rig.usual_bending) * random.uniform(0.015, 0.04) * out * fade)


def _reversals(rig: Rig, random: np.random.Generator) -> Array:
    """Slowly to and fro through standstill."""
    lasts = random.uniform(2.5, 4.5)
    t = np.arange(0.0, lasts, TICK_S)
    speed = random.uniform(0.015, 0.05)
    out: Array = speed * np.sin(2.0 * pi * t / lasts * float(random.integers(1, 4)))
    return out


_KINDS: list[Callable[[Rig, np.random.Generator], Array]] = [
    _fast_move,
    _steps,
    _chirp,
    _reversals,
    _move,
    _many_tones,
]
