"""The motion: Runge-Kutta of fourth order in steps of at most 0.25 ms, compiled. Everything is referred to the joint.

    command   held for a sample, after its dead zone and limit; first-order lag of the amplifier
    torque    gain * a - back_emf w - viscous w - dry(w) + ripple(theta) + offset          w: of the motor
    dry       F(w) tanh(w / width), F by direction, with a Stribeck part (Olsson et al., Eur. J. Control 4, 1998)
    rigid     M (theta'', q'') = (torque - gravity sin theta, -C q' - K q)
    geared    the motor's inertia apart from M; between them a contact outside +- gap / 2, which only pushes

The angle starts at rest. The controller of a closed loop sees the motor's angle and velocity with noise of its own.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from tests.hidden_world.driven.rig import Values

MOTOR, MOTOR_W, LINK, LINK_W, AMP, Q, V = 0, 1, 2, 3, 4, 5, 7
STATES = 9
LONGEST_STEP_S = 2.5e-4


class Laws(NamedTuple):
    """Numbers of the equations; what is 0 (or a huge limit) is absent."""

    gain: float
    back_emf: float = 0.0
    viscous: float = 0.0
    lag_s: float = 0.0
    limit: float = 1e12
    step: float = 0.0  # of the command
    dead_zone: float = 0.0  # of the command
    dead_shift: float = 0.0  # 1: what passes the dead zone is less by its width
    dry_up: float = 0.0  # N m, turning positively
    dry_down: float = 0.0
    stiction: float = 0.0  # share by which dry friction is more at rest
    stiction_w: float = 0.1  # rad/s
    dry_width: float = 1e-3  # rad/s
    ripple: float = 0.0  # N m
    ripple_turns: float = 1.0  # periods per turn of the joint
    ripple_phase: float = 0.0
    ripple_second: float = 0.0  # share of the second harmonic
    offset: float = 0.0  # N m
    gravity: float = 0.0  # N m
    gear_inertia: float = 0.0  # the motor's, where it is apart from the link
    gap: float = 0.0  # rad
    gear_stiffness: float = 0.0  # N m / rad
    gear_damping: float = 0.0  # N m s
    kp: float = 0.0
    kd: float = 0.0
    closed: float = 0.0


@njit(cache=True)
def _torque(x, command, laws):  # type: ignore[no-untyped-def]
    w = x[MOTOR_W]
    out = (
        laws.gain * (x[AMP] if laws.lag_s > 0.0 else command)
        - (laws.back_emf + laws.viscous) * w
        + laws.offset
    )
    if laws.dry_up > 0.0 or laws.dry_down > 0.0:
        level = laws.dry_up if w > 0.0 else laws.dry_down
        out -= (
            level
            * (1.0 + laws.stiction * np.exp(-((w / laws.stiction_w) ** 2)))
            * np.tanh(w / laws.dry_width)
        )
    if laws.ripple != 0.0:
        angle = laws.ripple_turns * x[MOTOR] + laws.ripple_phase
        out += laws.ripple * (np.sin(angle) + laws.ripple_second * np.sin(2.0 * angle))
    return out


@njit(cache=True)
def slope(x, command, laws, inverse, damping, stiffness, out):  # type: ignore[no-untyped-def]
    """Derivatives of the state x into out. inverse: of M."""
    n = len(stiffness)
    torque = _torque(x, command, laws)
    out[AMP] = (command - x[AMP]) / laws.lag_s if laws.lag_s > 0.0 else 0.0
    out[MOTOR], out[LINK] = x[MOTOR_W], x[LINK_W]
    load = torque
    if laws.gear_inertia > 0.0:
        apart, turning, half = x[MOTOR] - x[LINK], x[MOTOR_W] - x[LINK_W], 0.5 * laws.gap
        load = 0.0
        if laws.gap == 0.0:
            load = laws.gear_stiffness * apart + laws.gear_damping * turning
        elif apart > half:
            load = max(laws.gear_stiffness * (apart - half) + laws.gear_damping * turning, 0.0)
        elif apart < -half:
            load = min(laws.gear_stiffness * (apart + half) + laws.gear_damping * turning, 0.0)
        out[MOTOR_W] = (torque - load) / laws.gear_inertia
    load -= laws.gravity * np.sin(x[LINK])
    for i in range(n + 1):
        total = inverse[i, 0] * load
        for j in range(n):
            total -= inverse[i, j + 1] * (damping[j] * x[V + j] + stiffness[j] * x[Q + j])
        if i == 0:
            out[LINK_W] = total
        else:
            out[Q + i - 1], out[V + i - 1] = x[V + i - 1], total
    if laws.gear_inertia == 0.0:
        out[MOTOR_W] = out[LINK_W]


@njit(cache=True)
def integrate(start, wanted, seen, parts, h, laws, inverse, damping, stiffness):  # type: ignore[no-untyped-def]
    """Command asked for at each sample, shape (rows,), and states at each step, shape (rows * parts + 1, STATES).

    wanted: command or angle at each sample, shape (rows,); seen: noise of the controller's angle, velocity.
    """
    rows = len(wanted)
    states, asked = np.zeros((rows * parts + 1, STATES)), np.zeros(rows)
    x, y = start.copy(), np.zeros(STATES)
    k1, k2, k3, k4 = np.zeros(STATES), np.zeros(STATES), np.zeros(STATES), np.zeros(STATES)
    states[0] = x
    at = 0
    for row in range(rows):
        u = wanted[row]
        if laws.closed > 0.0:
            u = laws.kp * (u - x[MOTOR] - seen[row, 0]) - laws.kd * (x[MOTOR_W] + seen[row, 1])
        if laws.step > 0.0:
            u = np.round(u / laws.step) * laws.step
        asked[row] = u
        if abs(u) <= laws.dead_zone:
            u = 0.0
        else:
            u -= laws.dead_shift * laws.dead_zone * np.sign(u)
        u = min(max(u, -laws.limit), laws.limit)
        for _ in range(parts):
            slope(x, u, laws, inverse, damping, stiffness, k1)
            for i in range(STATES):
                y[i] = x[i] + 0.5 * h * k1[i]
            slope(y, u, laws, inverse, damping, stiffness, k2)
            for i in range(STATES):
                y[i] = x[i] + 0.5 * h * k2[i]
            slope(y, u, laws, inverse, damping, stiffness, k3)
            for i in range(STATES):
                y[i] = x[i] + h * k3[i]
            slope(y, u, laws, inverse, damping, stiffness, k4)
            for i in range(STATES):
                x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
            at += 1
            states[at] = x
    return asked, states


def kinetics(
    wanted: Values, seen: Values, rate_hz: float, laws: Laws, mass: Values, damping: Values, stiffness: Values,
    start: Values | None = None, finer: int = 1,
) -> tuple[Values, Values, float]:  # fmt: skip
    """integrate() with M itself, and the step in s. finer: divides the step, for tests."""
    parts = finer * int(np.ceil(1.0 / (rate_hz * LONGEST_STEP_S) - 1e-9))
    h = 1.0 / (rate_hz * parts)
    start = np.zeros(STATES) if start is None else start
    inverse = np.ascontiguousarray(np.linalg.inv(mass))
    asked, states = integrate(
        start, wanted, seen, parts, h, Laws(*map(float, laws)), inverse, damping, stiffness
    )
    return asked, states, h
