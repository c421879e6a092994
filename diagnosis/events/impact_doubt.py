"""How sure an impact is: its size over its doubt in the band in which the arm vibrates.

A fit's standard deviations take what it leaves for white. An image that drifts, or an accelerometer with hum, leaves
much at other frequencies and no more than noise about the arm's own, and an impact is seen there alone. So the doubt is
that of the noise's density about the mode, in the channel in which it is largest beside its level.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.fitting.fitted import Fit

Array = NDArray[np.float64]

_SHOWING = ("acceleration", "deflection", "displacement")
_PERIODS, _LEAST_SAMPLES = 12, 64  # of a window: a line is then told to a tenth of the mode's frequency
_ABOUT = 0.3  # of the frequency, to either side
_LEAST = 0.05  # of the level: below that the model's own discrepancy says how sure an impact is


def doubts_about_modes(last: Fit) -> list[float]:
    """Of each mode the noise about its frequency over that of the fit, both as deviations of white noise; at most 1."""
    return [_doubt_about_a_mode(last, mode) for mode in range(last.world.modes)]


def sizes_in_stds(last: Fit, doubts: Sequence[float]) -> list[float]:
    """Of each impact its size in standard deviations, the larger of the first mode's deflection's and rate's; while
    the joint rests, of all modes': a move sets off more of the higher ones than a model foretells that is a little
    wrong. doubts: `doubts_about_modes`."""
    world = last.world
    swing = round(1.0 / (last.value("modes.0.frequency_hz") * world.measured.cycle_s))
    found = []
    for number, cycle in enumerate(world.impacts, start=1):
        told_by = doubts if world.measured.rests_about(cycle, swing) else doubts[:1]
        found.append(max(size_of_mode(last, number, mode) / doubt for mode, doubt in enumerate(told_by)))
    return found


def size_of_mode(last: Fit, number: int, mode: int) -> float:
    """Of an impact its size in one mode, in the fit's own standard deviations."""
    size = 0.0
    for part in ("q", "v"):
        name = f"jump.{number}.{mode}.{part}"
        std = last.std.get(name, 0.0)
        unknown = 0.0 if mode else np.inf  # a higher mode's may show in no channel
        size = max(size, abs(last.value(name)) / std if std > 0.0 else unknown)
    return size


def _doubt_about_a_mode(last: Fit, mode: int) -> float:
    hz = last.value(f"modes.{mode}.frequency_hz")
    shares = [
        level_about(last.residuals[name], hz, last.world.step_s(name)) / last.sigma[name]
        for name in _SHOWING
        if name in last.residuals and last.sigma[name] > 0.0
    ]
    return float(np.clip(max(shares, default=1.0), _LEAST, 1.0))


def level_about(residual: Array, hz: float, step_s: float) -> float:
    """Standard deviation of white noise with as much power about a frequency as a residual has there, the median of
    windows that overlap by half (Welch 1967). residual: (n,), NaN where unknown, for which nothing is put in."""
    length = min(max(round(_PERIODS / (hz * step_s)), _LEAST_SAMPLES), len(residual))
    taper = np.hanning(length)
    at_hz = np.fft.rfftfreq(length, step_s)
    seen_hz = abs(hz - round(hz * step_s) / step_s)  # of a vibration that is faster than half the sampling
    about = np.abs(at_hz - seen_hz) <= max(_ABOUT * hz, 1.5 * at_hz[1])
    slope = np.linspace(-1.0, 1.0, length)
    powers = []
    for start in range(0, len(residual) - length + 1, max(length // 2, 1)):
        part = residual[start : start + length]
        known = np.isfinite(part)
        if known.sum() < 0.5 * length:
            continue
        line = np.polyfit(slope[known], part[known], 1)
        off = np.where(known, part - np.polyval(line, slope), 0.0) * taper
        power = np.abs(np.fft.rfft(off)[about]) ** 2
        powers.append(float(np.mean(power)) / float(np.sum((taper * known) ** 2)))
    return float(np.median(powers)) ** 0.5 if powers else np.inf
