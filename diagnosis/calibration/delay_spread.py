"""How far the capture delay strays about its mean, and how well either is known from a recording of limited length.

The delay is taken as a wander of the first order plus white noise, delay_k = mean + wander_k + white_k. For each share
of the wander and each correlation time the recording is whitened by a Kalman filter, mean and size are solved for, and
the answers are weighed by likelihood (uniform in share, and in the logarithms of time and size): a delay that wanders
slowly says little of its own mean, and the deviations stated tell so.
"""

from dataclasses import dataclass
from math import exp, log, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stillarm.diagnosis.data.robust import std_about_zero

Array = NDArray[np.float64]

_SHARES = (0.0, 0.1, 0.25, 0.4, 0.55, 0.7, 0.8, 0.87, 0.92, 0.96, 0.985)
_TIMES_S = np.geomspace(0.1, 60.0, 16)


@dataclass(frozen=True)
class DelaySpread:
    """std_s of the delay, with the deviation of that; mean_std_s: how well the recording fixes the mean."""

    std_s: float
    std_of_std_s: float
    mean_std_s: float


def delay_spread(late_s: Array, period_s: float, duration_s: float) -> DelaySpread:
    """late_s: how late each frame came, less a constant, in order; NaN where unknown. period_s: between frames."""
    r = late_s[np.isfinite(late_s)]
    r = r - np.median(r)
    limit = 6.0 * std_about_zero(r) + 1e-12
    r = np.clip(r, -limit, limit)
    n = len(r)
    logs, sizes, own_variances, means, mean_vars = [], [], [], [], []
    for share in _SHARES:
        for time_s in _TIMES_S[:1] if share == 0.0 else _TIMES_S:
            stay = exp(-period_s / time_s)
            square, cross, ones, log_power = _sums(r, share, stay)
            mean = cross / ones
            size = max(square - mean * cross, 1e-30) / (n - 1)
            logs.append(-0.5 * (n - 1) * log(size) - 0.5 * log_power - 0.5 * log(ones))
            sizes.append(sqrt(size))
            own_variances.append(size * _relative_std(share, stay, n) ** 2)
            means.append(mean)
            mean_vars.append(size / ones)
    weights = np.exp(np.array(logs) - max(logs))
    # each share but none is there as often as there are times
    weights[0] *= len(_TIMES_S)
    weights /= weights.sum()
    std = float(weights @ np.array(sizes))
    spread = float(weights @ (np.array(sizes) - std) ** 2 + weights @ np.array(own_variances))
    centre = float(weights @ np.array(means))
    mean_var = float(weights @ (np.array(mean_vars) + (np.array(means) - centre) ** 2))
    return DelaySpread(std, sqrt(spread), sqrt(mean_var))


@njit(cache=True, nogil=True)
def _sums(values: Array, share: float, stay: float) -> tuple[float, float, float, float]:
    """Sums over the innovations of the values and of ones, each over its variance, for a process of variance 1.

    Squares of the first, products, squares of the second; and the variances' logarithms.
    """
    white = max(1.0 - share, 1e-3)
    p, wander, one = share, 0.0, 0.0
    square, cross, ones, log_power = 0.0, 0.0, 0.0, 0.0
    for k in range(values.shape[0]):
        if k:
            p = stay * stay * p + share * (1.0 - stay * stay)
            wander, one = stay * wander, stay * one
        power = p + white
        left, left_one = values[k] - wander, 1.0 - one
        gain = p / power
        square += left * left / power
        cross += left * left_one / power
        ones += left_one * left_one / power
        log_power += np.log(power)
        wander += gain * left
        one += gain * left_one
        p -= gain * p
    return square, cross, ones, log_power


def _relative_std(share: float, stay: float, n: int) -> float:
    """Deviation of an estimated deviation, relative: 1 / sqrt(2 N) for N independent samples of as much worth."""
    alike = 1.0 + 2.0 * share**2 * stay**2 / max(1.0 - stay**2, 1e-9)
    return sqrt(0.5 * min(alike / n, 1.0))
