"""Frequency and damping of the free vibration, from nothing but the stretches in which the joint is told to stand.

In each stretch each channel is a decaying sinusoid of its own amplitude and phase about a constant; frequency and decay
are common to all. The amplitudes are linear and are projected out, so that two numbers remain to be searched (variable
projection: Golub and Pereyra, SIAM J. Numer. Anal. 10, 1973); the search starts at the peak of the mean periodogram.
"""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

Array = NDArray[np.float64]

_RATIOS = (0.002, 0.01, 0.04)  # damping ratios at which the search starts
_LOWEST_HZ, _HIGHEST_HZ = 0.3, 40.0
_RISE = 0.03  # of the stretch
_PER_PERIOD = 24.0  # samples that a sinusoid needs


@dataclass(frozen=True)
class Stretch:
    """One channel over one stretch: times from the stretch's start, s, and values over their noise level."""

    time_s: Array
    values: Array


@dataclass(frozen=True)
class Ringing:
    """frequency_hz: undamped. power: of the ringing over that of the noise, per sample."""

    frequency_hz: float
    damping_ratio: float
    power: float


def spectrum(stretches: list[Stretch]) -> tuple[Array, Array]:
    """Frequencies, Hz, and the mean periodogram of all stretches, each weighed by what it holds."""
    step = min(float(np.median(np.diff(one.time_s))) for one in stretches)
    step = max(step, 1.0 / (2.5 * _HIGHEST_HZ))
    longest = max(float(one.time_s[-1]) for one in stretches)
    length = 1 << int(np.ceil(np.log2(max(4.0 * longest / step, 64.0))))
    hz = np.asarray(np.fft.rfftfreq(length, step), dtype=np.float64)
    power: Array = np.zeros(len(hz))
    for one in stretches:
        grid = np.arange(0.0, one.time_s[-1], step)
        if len(grid) < 16:
            continue
        values = _means(one, grid, step)
        power += np.abs(np.fft.rfft((values - values.mean()) * _window(len(grid)), n=length)) ** 2
    power[(hz < _LOWEST_HZ) | (hz > _HIGHEST_HZ)] = 0.0
    return hz, power


def _window(length: int) -> Array:
    """A Hann window's falling half behind a short rise: what rings is at the beginning, where the whole one is zero."""
    along = np.arange(length) / length
    rise = np.sin(0.5 * pi * np.minimum(along / _RISE, 1.0)) ** 2
    window: Array = rise * np.cos(0.5 * pi * along) ** 2
    return window


def _means(one: Stretch, grid: Array, step: float) -> Array:
    """Values on a coarser grid: means of what lies in each step, so that nothing folds over."""
    place = np.minimum((one.time_s / step).astype(np.int64), len(grid) - 1)
    count = np.bincount(place, minlength=len(grid))
    total = np.bincount(place, one.values, minlength=len(grid))
    known = np.flatnonzero(count)
    return np.interp(np.arange(len(grid)), known, total[known] / count[known])


def peaks(stretches: list[Stretch], most: int = 4) -> list[float]:
    """Frequencies of the largest peaks of the spectrum, Hz, the largest first."""
    hz, power = spectrum(stretches)
    longest = max(float(one.time_s[-1]) for one in stretches)
    near = max(3, round(2.0 / longest / float(hz[1])))
    found = []
    for _ in range(most):
        at = int(np.argmax(power))
        if power[at] <= 0.0:
            break
        found.append(float(hz[at]))
        power[max(0, at - near) : at + near + 1] = 0.0
    return found


def ringing(stretches: list[Stretch], start_hz: float) -> Ringing:
    """The decaying sinusoid nearest to a frequency that is common to all stretches."""
    thin = [_thinned(one, _PER_PERIOD * start_hz) for one in stretches]
    longest = max(float(one.time_s[-1]) for one in thin)
    w0 = 2.0 * pi * start_hz

    def left(where: Array) -> Array:
        return np.concatenate([_projected(one, w0 + where[0], float(where[1])) for one in thin])

    # parts of a line's width: the peak is no finer than that
    starts = [np.array([s * 2.0 * pi / longest, ratio * w0]) for ratio in _RATIOS for s in (-0.3, 0.0, 0.3)]
    starts.sort(key=lambda begin: float(np.sum(left(begin) ** 2)))
    tried = [least_squares(left, one, x_scale=[1.0 / longest] * 2, max_nfev=40) for one in starts[:2]]
    best = min(tried, key=lambda one: float(one.cost))
    wd, decay = w0 + float(best.x[0]), float(best.x[1])
    w = sqrt(wd * wd + decay * decay)
    whole = sum(float(np.sum((one.values - one.values.mean()) ** 2)) for one in thin)
    count = sum(len(one.values) for one in thin)
    return Ringing(w / (2.0 * pi), min(max(decay / w, 1e-4), 0.5), (whole - 2.0 * best.cost) / count)


def _thinned(one: Stretch, rate_hz: float) -> Stretch:
    """Means of several samples where there are more than `rate_hz`."""
    step = float(np.median(np.diff(one.time_s)))
    many = int(1.0 / rate_hz / step)
    if many < 2:
        return one
    count = len(one.time_s) // many
    time = one.time_s[: count * many].reshape(count, many).mean(axis=1)
    values = one.values[: count * many].reshape(count, many).mean(axis=1) * sqrt(many)
    return Stretch(time, values)


def _projected(one: Stretch, wd: float, decay: float) -> Array:
    """What a decaying sinusoid about a constant, fitted linearly, leaves of a stretch."""
    t = one.time_s
    with np.errstate(over="ignore"):
        fade = np.exp(np.clip(-decay * t, -50.0, 50.0))
    basis = np.column_stack((fade * np.cos(wd * t), fade * np.sin(wd * t), np.ones(len(t))))
    q, _ = np.linalg.qr(basis)
    left: Array = one.values - q @ (q.T @ one.values)
    return left
