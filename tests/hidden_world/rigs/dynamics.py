"""The motion: Runge-Kutta of fourth order with a fixed step of 0.1 ms, compiled.

    motor    w' = clip(2 pi B (c - w) - friction(w))                 c: the command after its dead time [and a second
    lag] link     theta = motor, or behind a play: contact of stiffness k and damping d outside +- gap/2, else -drag
    theta' modes    q_i'' = -2 z_i w_i q_i' - w_i^2 q_i - p_i L theta'' + push_i F(t) [+ what effects add to the
    first] second   y'' = -2 z w y' - w^2 y + c1 w1^2 q1 - c2 theta''       an oscillator beside the arm: cross axis,
    torsion mount    m'' = -2 z w m' - w^2 m - s''                           the camera, loose on its mount tip
    s'' = L theta'' + sum q_i''

Stiffness and damping of the modes take factors that change from cycle to cycle. Inputs are constant over a step, but
the force, which is given at the steps' ends and middles.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from tests.hidden_world.rigs.rig import FINE, STEP_S, Values

STATES = 16
MOTOR, MOTOR_W, LINK, LINK_W, SLOW, Q, V, HYST, SIDE, SIDE_V, MOUNT, MOUNT_V = (
    0,
    1,
    2,
    3,
    4,
    5,
    8,
    11,
    12,
    13,
    14,
    15,
)


class Laws(NamedTuple):
    """Numbers of the equations; what is 0 (or a huge limit) is absent."""

    length_m: float
    lag_up: float  # 2 pi B where the command speeds the motor up, 1/s
    lag_down: float  # where it slows it down
    second_lag: float = 0.0  # 1/s
    most_up: float = 1e9  # rad/s^2, in the positive direction
    most_down: float = 1e9
    friction_up: float = 0.0  # rad/s^2, turning positively
    friction_down: float = 0.0
    stiction: float = 0.0  # share by which it is more at rest
    stiction_width: float = 0.01  # rad/s
    friction_width: float = 5e-4
    friction_from_s: float = 0.0
    gap: float = 0.0  # rad
    gear_stiffness: float = 0.0  # 1/s^2
    gear_damping: float = 0.0  # 1/s
    gear_drag: float = 0.0  # 1/s
    coulomb: float = 0.0  # m/s^2
    coulomb_width: float = 1e-3  # m/s
    power_damping: float = 0.0  # q'' + c |q'|^(n-1) q'
    power: float = 2.0
    cubic: float = 0.0  # 1/m^2
    fifth: float = 0.0  # 1/m^4
    arm_from_s: float = 0.0  # when those in the arm begin
    skew: float = 0.0  # 1/m: a quadratic term of the stiffness
    side_step: float = 0.0  # the stiffness is 1 + that for q > 0, 1 - that for q < 0
    hysteresis: float = 0.0  # share of the stiffness
    hysteresis_m: float = 1.0
    hysteresis_power: float = 1.0
    side_w: float = 0.0  # 1/s
    side_z: float = 0.01
    side_from_bending: float = 0.0
    side_from_joint: float = 0.0  # m
    side_back: float = 0.0
    mount_w: float = 0.0
    mount_z: float = 0.02
    centrifugal: float = 0.0  # relative stiffness per (rad/s)^2
    stop_m: float = 1e9
    stop_stiffness: float = 0.0  # relative to the mode's


@njit(cache=True)
def _motor(t, x, c, laws, out):  # type: ignore[no-untyped-def]
    """The motor's derivatives into out."""
    out[SLOW] = 0.0
    if laws.second_lag > 0.0:
        out[SLOW] = laws.second_lag * (c - x[SLOW])
        c = x[SLOW]
    speed = x[MOTOR_W]
    pull = c - speed
    a = (laws.lag_up if pull * speed >= 0.0 else laws.lag_down) * pull
    if (laws.friction_up > 0.0 or laws.friction_down > 0.0) and t >= laws.friction_from_s:
        grip = laws.friction_up if speed > 0.0 else laws.friction_down
        more = 1.0 + laws.stiction * np.exp(-((speed / laws.stiction_width) ** 2))
        a -= grip * more * np.tanh(speed / laws.friction_width)
    out[MOTOR], out[MOTOR_W] = speed, min(max(a, -laws.most_down), laws.most_up)


@njit(cache=True)
def _link(x, laws, out):  # type: ignore[no-untyped-def]
    """The link's derivatives into out, after the motor's; returns theta''."""
    if laws.gap <= 0.0:
        out[LINK], out[LINK_W] = out[MOTOR], out[MOTOR_W]
        return out[LINK_W]
    apart, half, turning = x[MOTOR] - x[LINK], 0.5 * laws.gap, x[MOTOR_W] - x[LINK_W]
    al = -laws.gear_drag * x[LINK_W]
    if apart > half:
        al = max(laws.gear_stiffness * (apart - half) + laws.gear_damping * turning, 0.0)
    elif apart < -half:
        al = min(laws.gear_stiffness * (apart + half) + laws.gear_damping * turning, 0.0)
    out[LINK], out[LINK_W] = x[LINK_W], al
    return al


@njit(cache=True)
def _first(t, x, stiff, damp, laws, w, z, out):  # type: ignore[no-untyped-def]
    """What acts on the first mode from within the arm, m/s^2; the hysteresis' derivative into out."""
    q, v, k = x[Q], x[V], w * w * stiff
    b = -k * q * (1.0 + laws.centrifugal * x[LINK_W] * x[LINK_W])
    b -= 2.0 * z * damp * w * np.sqrt(stiff) * v
    b -= k * (laws.skew * q * q + laws.side_step * abs(q)) - laws.side_back * k * x[SIDE]
    if t >= laws.arm_from_s:
        if laws.coulomb != 0.0:
            b -= laws.coulomb * np.tanh(v / laws.coulomb_width)
        if laws.power_damping != 0.0:
            b -= laws.power_damping * abs(v) ** (laws.power - 1.0) * v
        b -= k * (laws.cubic * q * q * q + laws.fifth * q * q * q * q * q)
    out[HYST] = 0.0
    if laws.hysteresis != 0.0:
        y = x[HYST]
        part = abs(y) ** laws.hysteresis_power
        out[HYST] = (v - 0.5 * (abs(v) * y / max(abs(y), 1e-12) + v) * part) / laws.hysteresis_m
        b -= k * laws.hysteresis * laws.hysteresis_m * y
    if q > laws.stop_m:
        b -= k * laws.stop_stiffness * (q - laws.stop_m)
    return b


@njit(cache=True)
def slope(t, x, c, f, stiff, damp, laws, w, z, p, push, out):  # type: ignore[no-untyped-def]
    """Derivatives of the state x into out; returns s''."""
    _motor(t, x, c, laws, out)
    al = _link(x, laws, out)
    total = laws.length_m * al
    for i in range(len(w)):
        q, v = x[Q + i], x[V + i]
        b = -w[i] * w[i] * q - 2.0 * z[i] * w[i] * v
        if i == 0:
            b = _first(t, x, stiff, damp, laws, w[0], z[0], out)
        b += push[i] * f - p[i] * laws.length_m * al
        out[Q + i], out[V + i] = v, b
        total += b
    out[SIDE] = out[SIDE_V] = out[MOUNT] = out[MOUNT_V] = 0.0
    if laws.side_w > 0.0:
        out[SIDE] = x[SIDE_V]
        out[SIDE_V] = -laws.side_w * (2.0 * laws.side_z * x[SIDE_V] + laws.side_w * x[SIDE])
        out[SIDE_V] += laws.side_from_bending * w[0] * w[0] * x[Q] - laws.side_from_joint * al
    if laws.mount_w > 0.0:
        out[MOUNT] = x[MOUNT_V]
        out[MOUNT_V] = -laws.mount_w * (2.0 * laws.mount_z * x[MOUNT_V] + laws.mount_w * x[MOUNT]) - total
    return total


@njit(cache=True)
def integrate(start, command, force, stiff, damp, laws, w, z, p, push):  # type: ignore[no-untyped-def]
    """States at all ends of steps, shape (steps + 1, STATES), and s'' just before each, shape (steps + 1,).

    command: shape (steps,); force: shape (2 steps + 1,); stiff, damp: shape (cycles,).
    """
    steps, h = len(command), STEP_S
    rows, tip = np.zeros((steps + 1, STATES)), np.zeros(steps + 1)
    x, y = start.copy(), np.zeros(STATES)
    k1, k2, k3, k4 = np.zeros(STATES), np.zeros(STATES), np.zeros(STATES), np.zeros(STATES)
    rows[0] = x
    tip[0] = slope(0.0, x, 0.0, force[0], stiff[0], damp[0], laws, w, z, p, push, k1)
    for n in range(steps):
        t, c, m = n * h, command[n], n // FINE
        s, d = stiff[m], damp[m]
        f0, f1, f2 = force[2 * n], force[2 * n + 1], force[2 * n + 2]
        slope(t, x, c, f0, s, d, laws, w, z, p, push, k1)
        for i in range(STATES):
            y[i] = x[i] + 0.5 * h * k1[i]
        slope(t + 0.5 * h, y, c, f1, s, d, laws, w, z, p, push, k2)
        for i in range(STATES):
            y[i] = x[i] + 0.5 * h * k2[i]
        slope(t + 0.5 * h, y, c, f1, s, d, laws, w, z, p, push, k3)
        for i in range(STATES):
            y[i] = x[i] + h * k3[i]
        slope(t + h, y, c, f2, s, d, laws, w, z, p, push, k4)
        for i in range(STATES):
            x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
        rows[n + 1] = x
        tip[n + 1] = slope(t + h, x, c, f2, s, d, laws, w, z, p, push, k1)
    return rows, tip


def kinetics(
    start: Values, command: Values, force: Values, stiff: Values, damp: Values, laws: Laws, modes: Values
) -> tuple[Values, Values]:
    """integrate(), with modes: shape (modes, 4), a row (w in 1/s, damping ratio, participation, push)."""
    w, z, p, push = (np.ascontiguousarray(modes[:, k]) for k in range(4))
    rows, tip = integrate(start, command, force, stiff, damp, Laws(*map(float, laws)), w, z, p, push)
    return rows, tip
