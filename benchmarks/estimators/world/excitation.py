"""Excitations other than repeated impacts: a pull that is released, a push by hand, a single impact after rest.

A hand is a force on the mode. While the force is constant, the image shows the deflection force / w^2. The
accelerometer measures q'' only and does not show it.
"""

from itertools import pairwise
from math import pi, sin

import numpy as np

from stillarm.benchmarks.estimators.world.generator import (
    Excitation,
    Motion,
    Piece,
    motion_of,
    pole_of,
    reach,
    strike_again,
)
from stillarm.benchmarks.estimators.world.regimes import Arm

FIRST_S = 2.5  # the arm is at rest until then
LET_GO_S = 0.002  # time in which fingers open
_KNOT_S = 0.02  # spacing of the knots of a hand's force, with straight lines between them
_GROWS_S, _HELD_S = (0.6, 1.2), (0.5, 1.5)
_SLOWLY_S, _LONG_S = (2.0, 3.0), (1.0, 3.0)
_RING_S = (4.5, 5.5)
_PUSH_S = (0.15, 0.3)  # a period lasts 0.385 s: longer pushes hardly excite
_PUSH_EVERY_S = (3.0, 4.0)
_SIZE = (1.0, 1.5)  # of the static deflection, in amplitudes
_STILL_S = 1.0  # from the last impact to a pull

Force = list[tuple[float, float]]
"""Knots (time, s; force, m/s^2), with straight lines between them; zero before and after."""


def released_again(arm: Arm, duration_s: float, random: np.random.Generator) -> Motion:
    """An arm at rest is pulled aside, held and released. It rings and is pulled again."""
    pulls: list[Force] = []
    at = FIRST_S
    while at < duration_s:
        pulls.append(_pull(arm, at, _GROWS_S, _HELD_S, random))
        at = pulls[-1][-1][0] + random.uniform(*_RING_S)
    return _forced(_at_rest(arm), arm, pulls)


def pushed_again(arm: Arm, duration_s: float, random: np.random.Generator) -> Motion:
    """An arm at rest is repeatedly pushed by hand to either side."""
    pushes: list[Force] = []
    at = FIRST_S
    while at < duration_s:
        length = random.uniform(*_PUSH_S)
        size = random.choice((-1.0, 1.0)) * random.uniform(*_SIZE) * _force_per_amplitude(arm)
        grows = _swell(at, 0.5 * length, size)
        falls = [(time + 0.5 * length, size - force) for time, force in grows]
        pushes.append(grows + falls[1:])
        at += random.uniform(*_PUSH_EVERY_S)
    return _forced(_at_rest(arm), arm, pushes)


def struck_once(arm: Arm, duration_s: float, random: np.random.Generator) -> Motion:
    """An arm at rest is struck once and rings."""
    at = FIRST_S + random.uniform()
    force = random.uniform(*arm.impact_to) * arm.angular_frequency * arm.amplitude_m / arm.impact_s
    return _forced(_at_rest(arm), arm, [[(at, force), (at + arm.impact_s, force)]])


def pulled_slowly_at(from_s: float) -> Excitation:
    """Repeated impacts until shortly before `from_s`; then a slow pull that is held and released."""

    def excite(arm: Arm, duration_s: float, random: np.random.Generator) -> Motion:
        struck = strike_again(arm, from_s - _STILL_S, random)
        pieces: list[Piece] = [
            (float(start), float(q), float(v), complex(pole), float(force))
            for start, q, v, pole, force in zip(
                struck.start_s,
                struck.deflection_m,
                struck.rate_m_s,
                struck.pole,
                struck.force_m_s2,
                strict=True,
            )
        ]
        pull = _pull(arm, from_s, _SLOWLY_S, _LONG_S, random)
        return _forced(pieces, arm, [pull], struck.impacts_s.tolist(), struck.impact_velocity_m_s.tolist())

    return excite


def _pull(
    arm: Arm,
    at_s: float,
    grows_s: tuple[float, float],
    held_s: tuple[float, float],
    random: np.random.Generator,
) -> Force:
    size = random.choice((-1.0, 1.0)) * random.uniform(*_SIZE) * _force_per_amplitude(arm)
    grows = _swell(at_s, random.uniform(*grows_s), size)
    held = grows[-1][0] + random.uniform(*held_s)
    return [*grows, (held, size), (held + LET_GO_S, 0.0)]


def _swell(at_s: float, lasts_s: float, size: float) -> Force:
    """A rise from zero to `size`, as a squared sine."""
    steps = np.linspace(0.0, 1.0, max(2, round(lasts_s / _KNOT_S)) + 1)
    return [(at_s + lasts_s * float(x), size * sin(0.5 * pi * float(x)) ** 2) for x in steps]


def _force_per_amplitude(arm: Arm) -> float:
    return arm.angular_frequency**2 * arm.amplitude_m


def _at_rest(arm: Arm) -> list[Piece]:
    return [(0.0, 0.0, 0.0, pole_of(arm), 0.0)]


def _forced(
    pieces: list[Piece],
    arm: Arm,
    forces: list[Force],
    impacts: list[float] | None = None,
    velocities: list[float] | None = None,
) -> Motion:
    """The motion of `pieces` under further forces, in order. Each end counts as an impact of unknown velocity."""
    pole = pole_of(arm)
    ends = [force[-1][0] for force in forces]
    for force in forces:
        for (from_s, first), (to_s, last) in pairwise(force):
            pieces.append((from_s, *reach(pieces, from_s), pole, first, (last - first) / (to_s - from_s)))
        pieces.append((force[-1][0], *reach(pieces, force[-1][0]), pole, 0.0))
    spans = [(force[0][0], force[-1][0]) for force in forces]
    unknown = [float("nan")] * len(ends)
    return motion_of(pieces, (impacts or []) + ends, (velocities or []) + unknown, spans)
