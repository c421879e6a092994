"""Bursts of late frames: a hidden Markov chain of two states over a delay that wanders.

    r_k = w_k + size z_k + e_k,   w_k = stay w_{k-1} + drive,   z_k in {0, 1} a Markov chain

Filtered by one Kalman filter for each pair of successive states, merged after every frame (generalised pseudo-Bayesian
estimator of second order; Bar-Shalom, Li and Kirubarajan, Estimation with Applications, 2001, section 11.6.4). Without
bursts it is the wander alone: a delay that merely wanders, or scatters, is no burst.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from math import log

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, minimize

from stillarm.diagnosis.data.noise import MIN_ARRIVALS
from stillarm.diagnosis.data.robust import std_about_median
from stillarm.diagnosis.physics.copies import shared_out

Array = NDArray[np.float64]

_SHORTEST_FRAMES = 2.5  # mean length of a burst at least: what is shorter is the delay's scatter
_NO_WANDER = 1e-12  # of the residual's variance
_LONGEST_STAY = 0.9995  # correlation of a wander from frame to frame at most: 2000 frames


@dataclass(frozen=True)
class Bursts:
    """The likeliest chain. size_s: how much later; enter, leave: probabilities per frame; late: of each frame."""

    size_s: float
    enter: float
    leave: float
    nats: Array
    plain_nats: Array
    late: Array


@dataclass(frozen=True)
class Wander:
    """The likeliest wander alone. stay: its correlation from frame to frame; std, noise_std: of the wander and of the
    noise beside it; nats, white_nats: with it, and of noise alone; innovations: what it does not foretell, in
    deviations, (frames,), NaN where unknown."""

    stay: float
    std: float
    noise_std: float
    nats: float
    white_nats: float
    innovations: Array


@njit(cache=True, nogil=True)
def _filter(
    r: Array, stay: float, wander: float, white: float, size: float, spread: float,
    enter: float, leave: float, nats: Array, late: Array,
) -> None:  # fmt: skip
    """Predictive log-likelihood of each residual, and probability of the late state after it. Variances in s^2."""
    mean, var, prob = np.zeros(2), np.full(2, wander), np.empty(2)
    prob[1] = enter / (enter + leave)
    prob[0] = 1.0 - prob[1]
    drive = wander * (1.0 - stay * stay)
    m, p, weight = np.empty((2, 2)), np.empty((2, 2)), np.empty((2, 2))
    for k in range(r.shape[0]):
        total = 0.0
        for i in range(2):
            ahead, doubt = stay * mean[i], stay * stay * var[i] + drive
            for j in range(2):
                change = (enter if j else 1.0 - enter) if i == 0 else (1.0 - leave if j else leave)
                if np.isnan(r[k]):
                    m[i, j], p[i, j], weight[i, j] = ahead, doubt, prob[i] * change
                else:
                    s = doubt + white + (spread if j else 0.0)
                    off = r[k] - ahead - (size if j else 0.0)
                    u = off * off / s
                    # an outlier weighs no more than its size (Huber)
                    cost = 0.5 * u if u < 16.0 else 4.0 * np.sqrt(u) - 8.0
                    gain = doubt / s * (1.0 if u < 16.0 else 4.0 / np.sqrt(u))
                    m[i, j], p[i, j] = ahead + gain * off, doubt * (1.0 - gain)
                    weight[i, j] = prob[i] * change * np.exp(-cost) / np.sqrt(2.0 * np.pi * s)
                total += weight[i, j]
        total = max(total, 1e-300)
        nats[k] = 0.0 if np.isnan(r[k]) else np.log(total)
        for j in range(2):
            prob[j] = max((weight[0, j] + weight[1, j]) / total, 1e-12)
            share = weight[0, j] / max(weight[0, j] + weight[1, j], 1e-300)
            mean[j] = share * m[0, j] + (1.0 - share) * m[1, j]
            var[j] = share * (p[0, j] + (m[0, j] - mean[j]) ** 2) + (1.0 - share) * (
                p[1, j] + (m[1, j] - mean[j]) ** 2
            )
        late[k] = prob[1]


@njit(cache=True, nogil=True)
def _innovations(r: Array, stay: float, wander: float, white: float, out: Array) -> None:
    """What each residual is off what those before it foretell, in deviations; NaN stays. Variances in s^2."""
    mean, var = 0.0, wander
    for k in range(r.shape[0]):
        ahead, doubt = stay * mean, stay * stay * var + wander * (1.0 - stay * stay)
        off, s = r[k] - ahead, doubt + white
        out[k] = off / np.sqrt(s)
        mean, var = ahead, doubt
        if not np.isnan(off):
            mean, var = ahead + doubt / s * off, doubt * (1.0 - doubt / s)


def _filtered(
    r: Array,
    stay: float,
    wander: float,
    white: float,
    size: float = 0.0,
    spread: float = 0.0,
    enter: float = 1e-9,
    leave: float = 0.5,
) -> tuple[Array, Array]:
    """The log-likelihood of each frame, and the probability that it is late, as `_filter` has it; without bursts unless
    they have a size."""
    nats, late = np.empty(len(r)), np.empty(len(r))
    _filter(r, stay, wander, white, size, spread, enter, leave, nats, late)
    return nats, late


def wander_of(residual: Array) -> Wander | None:
    """Fit a wander and white noise to a frames' channel, (frames,) in any unit, NaN where unknown; None of too few."""
    known = residual[np.isfinite(residual)]
    if len(known) < MIN_ARRIVALS:
        return None
    scale = std_about_median(known) + 1e-12
    r = (residual - float(np.median(known))) / scale
    innovations = np.empty(len(r))

    def nats_of(x: Array) -> float:
        stay = _LONGEST_STAY / (1.0 + np.exp(-x[0]))
        nats, _ = _filtered(r - x[3], stay, np.exp(x[1]), np.exp(x[2]))
        return float(nats.sum())

    def cost(x: Array) -> float:
        return -nats_of(x) + 0.005 * float(np.sum(x * x))

    best = _likeliest(cost, [np.array([start, -1.0, -1.0, 0.0]) for start in (2.0, 5.0)], 400)
    stay, wander, white = _LONGEST_STAY / (1.0 + np.exp(-best.x[0])), np.exp(best.x[1]), np.exp(best.x[2])
    without, _ = _filtered(r, 0.0, _NO_WANDER, float(np.nanvar(r)))
    _innovations(r - best.x[3], stay, wander, white, innovations)
    return Wander(
        float(stay), scale * float(np.sqrt(wander)), scale * float(np.sqrt(white)),
        nats_of(best.x) - len(known) * log(scale), float(without.sum()) - len(known) * log(scale), innovations,
    )  # fmt: skip


def _likeliest(cost: Callable[[Array], float], starts: Sequence[Array], most: int) -> OptimizeResult:
    """The least cost from any of these starts, by Nelder and Mead's method. most: values of it that are asked for."""
    options = {"maxfev": most}
    found = shared_out(lambda start: minimize(cost, start, (), "Nelder-Mead", options=options), starts)
    return min(found, key=lambda one: float(one.fun))


def find_bursts(residual_s: Array, used: NDArray[np.bool_]) -> Bursts | None:
    """Fit both laws to the residuals that are `used`; nats of all. None: no bursts fit at all."""
    known = residual_s[np.isfinite(residual_s)]
    if len(known) < MIN_ARRIVALS:
        return None
    scale = std_about_median(known) + 1e-6
    r = (residual_s - float(np.median(known))) / scale

    def run(x: Array, bursts: bool) -> tuple[Array, Array]:
        stay = _LONGEST_STAY / (1.0 + np.exp(-x[0]))
        mean = x[3]
        if bursts:
            enter = 0.5 / (1.0 + np.exp(-x[5]))
            leave = 1.0 / _SHORTEST_FRAMES / (1.0 + np.exp(-x[6]))
            size, spread = float(np.exp(x[4])), float(np.exp(x[7]))
            return _filtered(r - mean, stay, np.exp(x[1]), np.exp(x[2]), size, spread, enter, leave)
        return _filtered(r - mean, stay, np.exp(x[1]), np.exp(x[2]))

    def cost(x: Array, bursts: bool) -> float:
        nats, _ = run(x, bursts)
        return -float(nats[used].sum()) + 0.005 * float(np.sum(x * x))

    starts = [np.array([start, -1.0, -0.7, 0.0]) for start in (2.0, 5.0)]
    plain = _likeliest(partial(cost, bursts=False), starts, 300)
    plain_nats, _ = run(plain.x, False)
    starts = [
        np.array([*plain.x[:3], plain.x[3] - part, np.log(size), np.log(part / 5.0), -0.5, -1.0])
        for size in (2.0, 5.0, 15.0, 40.0)
        for part in (0.03, 0.3)
    ]
    best = _likeliest(partial(cost, bursts=True), starts, 250)
    best = _likeliest(partial(cost, bursts=True), [best.x], 600)
    nats, late = run(best.x, True)
    enter = 0.5 / (1.0 + float(np.exp(-best.x[5])))
    leave = 1.0 / _SHORTEST_FRAMES / (1.0 + float(np.exp(-best.x[6])))
    return Bursts(
        float(np.exp(best.x[4])) * scale, enter, leave, nats, plain_nats, _smoothed(late, enter, leave)
    )


def _smoothed(late: Array, enter: float, leave: float) -> Array:
    """Probability of the late state given the frames after it too (backward pass of the chain; Kim, 1994)."""
    out = late.copy()
    for k in range(len(late) - 2, -1, -1):
        ahead = late[k] * (1.0 - leave) + (1.0 - late[k]) * enter
        stays = late[k] * (1.0 - leave) / max(ahead, 1e-12)
        ends = late[k] * leave / max(1.0 - ahead, 1e-12)
        out[k] = out[k + 1] * stays + (1.0 - out[k + 1]) * ends
    return out
