"""What follows from the arm's motion in closed form: the tip, and how a linear mode answers a jump or a force.

The motion itself is that of stillarm.simulation.arm. What is run at each simulation is compiled.
"""

from math import tan

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.signal import lfilter

Array = NDArray[np.float64]


@njit(cache=True, nogil=True, error_model="numpy")
def tip_of(
    joint: Array,
    q: Array,
    qdd: Array,
    length: float,
    slopes: Array,
    out_deflection: Array,
    out_tip: Array,
    out_acceleration: Array,
    out_angle: Array,
) -> None:
    """The tip's deflection, m, path, m, its acceleration, m/s^2, and angle, rad, from what `free_run` fills.

    slopes: (m,) tip's angle by the deflection of each mode, rad/m.
    """
    for k in range(joint.shape[0]):
        deflection = acceleration = angle = 0.0
        for i in range(q.shape[1]):
            deflection += q[k, i]
            acceleration += qdd[k, i]
            angle += slopes[i] * q[k, i]
        out_deflection[k] = deflection
        out_tip[k] = length * joint[k, 0] + deflection
        out_acceleration[k] = length * joint[k, 2] + acceleration
        out_angle[k] = joint[k, 0] + angle


@njit(cache=True, nogil=True, error_model="numpy")
def free_decay(frequency_hz: float, damping_ratio: float, dt: float, out: Array) -> None:
    """A free mode from q = 1, q' = 0 and from q = 0, q' = 1, at each cycle: out (n, 4): q and q'' of either."""
    w = 2.0 * np.pi * frequency_hz
    sig, wd = damping_ratio * w, w * np.sqrt(max(1e-12, 1.0 - damping_ratio**2))
    decay = np.exp(-sig * dt)
    c, s = decay * np.cos(wd * dt), decay * np.sin(wd * dt)
    x, y = 1.0, 0.0  # exp(-sig t) cos(wd t), exp(-sig t) sin(wd t)
    for k in range(out.shape[0]):
        q, v = x + sig / wd * y, -w * w / wd * y
        out[k, 0], out[k, 1] = q, -2.0 * sig * v - w * w * q
        q, v = y / wd, x - sig / wd * y
        out[k, 2], out[k, 3] = q, -2.0 * sig * v - w * w * q
        x, y = c * x - s * y, c * y + s * x


@njit(cache=True, nogil=True, error_model="numpy")
def add_decay(
    decay: Array,
    first: int,
    dq: float,
    dv: float,
    slope: float,
    q: Array,
    deflection: Array,
    tip: Array,
    acceleration: Array,
    angle: Array,
) -> None:
    """Add to a mode's q, and to what `tip_of` fills, its answer to a jump by dq and dv at cycle `first`.

    decay: (n, 4) of `free_decay`. slope: tip's angle by the mode's deflection, rad/m.
    """
    for k in range(first, q.shape[0]):
        more = dq * decay[k - first, 0] + dv * decay[k - first, 2]
        q[k] += more
        deflection[k] += more
        tip[k] += more
        angle[k] += slope * more
        acceleration[k] += dq * decay[k - first, 1] + dv * decay[k - first, 3]


def deflection_of_mode(force: Array, frequency_hz: float, damping_ratio: float, step_s: float) -> Array:
    """Deflection, m, of a mode under forces, (samples,) or (samples, k) m/s^2, from rest: q of
    q'' + 2 z w q' + w^2 q = force (bilinear, with a pre-warped frequency: exact at w)."""
    _, a = _filter_of_mode(frequency_hz, damping_ratio, step_s)
    return np.asarray(lfilter(np.array([1.0, 2.0, 1.0]) / a[0], a / a[0], force, axis=0))


def acceleration_of_mode(force: Array, frequency_hz: float, damping_ratio: float, step_s: float) -> Array:
    """The second derivative of `deflection_of_mode`, m/s^2."""
    k, a = _filter_of_mode(frequency_hz, damping_ratio, step_s)
    return np.asarray(lfilter(k * k / a[0] * np.array([1.0, -2.0, 1.0]), a / a[0], force, axis=0))


def answer_of_mode(
    force: Array, frequency_hz: float, damping_ratio: float, step_s: float
) -> tuple[Array, Array]:
    """Deflection, m, and its acceleration, m/s^2, of a mode under forces, (samples, k) m/s^2, from rest."""
    mode = frequency_hz, damping_ratio, step_s
    return deflection_of_mode(force, *mode), acceleration_of_mode(force, *mode)


def _filter_of_mode(frequency_hz: float, damping_ratio: float, step_s: float) -> tuple[float, Array]:
    """k of s = k (1 - 1/z) / (1 + 1/z), 1/s, and the denominator of a mode's answers, by falling powers of z."""
    w = 2.0 * np.pi * frequency_hz
    k = w / tan(0.5 * w * step_s)
    drag = 2.0 * damping_ratio * w * k
    return k, np.array([k * k + drag + w * w, 2.0 * (w * w - k * k), k * k - drag + w * w])
