"""Scores of one method's estimates against the truth of a run. Arrays in, numbers out.

error       |estimate - truth| over the true amplitude at that time (the largest deflection half a period either side),
            where that is above 30 % of the swing's largest; from 0.5 s after the swing's beginning on. No estimate
            counts as 1.
delay       stated delay - (received_s - true mid-exposure), from 1 s after the swing's beginning on
normalised  mean of (error / stated standard deviation)^2 in windows of 5 s, the largest of them. 1 is honest; far
            above 1 is wrong and sure (Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and
            Navigation, 2001, section 5.4)
settled_s   from the swing's beginning until the running mean of the error over 0.25 s stays below 2 %
longest_beyond_2_std_s
            the longest time for which |estimate - truth| exceeded twice its stated standard deviation, from the first
            strike to the end. The error of a vibration passes through zero twice a period: breaks of up to half a
            period do not end such a time.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stillarm.benchmarks.live.truth import Swing, TrueRun, Values

_VISIBLE = 0.3  # of the swing's largest amplitude: below it, a relative error says little
_ERROR_FROM_S, _DELAY_FROM_S = 0.5, 1.0
_WINDOW_S = 5.0
_FEWEST = 20  # values that a window needs
_SETTLED, _SETTLED_OVER_S = 0.02, 0.25
_BEYOND = 2.0  # standard deviations


@dataclass(frozen=True)
class Estimates:
    """What a method said: in each cycle (the first three), and for each frame (the others). NaN: it said nothing."""

    time_s: Values
    deflection_m: Values
    deflection_std_m: Values
    frame: NDArray[np.int64]
    received_s: Values
    delay_s: Values
    delay_std_s: Values


def score(said: Estimates, truth: TrueRun) -> dict[str, float | None]:
    """The scores by their names in the benchmark's file; None where there was nothing to judge."""
    true = np.interp(said.time_s, truth.time_s, truth.deflection_m)
    mid = np.array([truth.mid_exposure_s.get(int(frame), np.nan) for frame in said.frame])
    error = said.deflection_m - true
    delay_error = said.delay_s - (said.received_s - mid)
    relative, lost, late, settled = [], [], [], []
    of_delay, of_deflection = [], []
    for swing in truth.swings:
        visible, amplitude = visible_amplitude(truth, swing, said.time_s)
        seen, _ = visible_amplitude(truth, swing, said.received_s)
        of_swing = np.where(np.isfinite(error), np.abs(error) / amplitude, 1.0)
        scored = visible & (said.time_s >= swing.begin_s + _ERROR_FROM_S)
        relative.append(of_swing[scored])
        lost.append(~np.isfinite(error[scored]))
        settled.append(settled_s(said.time_s[visible], of_swing[visible], swing.begin_s))
        dated = seen & np.isfinite(delay_error) & (said.received_s >= swing.begin_s + _DELAY_FROM_S)
        late.append(delay_error[dated])
        of_deflection += _normalised(said.time_s, error, said.deflection_std_m, visible, swing)
        of_delay += _normalised(said.received_s, delay_error, said.delay_std_s, seen, swing)
    all_relative, all_late = np.concatenate(relative), np.concatenate(late)
    return {
        "error_mean": _of(np.mean, all_relative),
        "error_max": _of(np.max, all_relative),
        "lost_share": _of(np.mean, np.concatenate(lost).astype(float)),
        "delay_mean_s": _of(np.mean, all_late),
        "delay_rms_s": _of(lambda values: np.sqrt(np.mean(values**2)), all_late),
        "delay_normalised_error_squared_max": max(of_delay, default=None),
        "deflection_normalised_error_squared_max": max(of_deflection, default=None),
        "settled_s": max((value for value in settled if value is not None), default=None),
        "longest_beyond_2_std_s": longest_beyond_s(said, error, truth, truth.swings[0].begin_s),
    }


def period_s(truth: TrueRun) -> float:
    """The vibration's period: the median time between two crossings of zero upwards in the first swing."""
    swing = truth.swings[0]
    inside = (truth.time_s >= swing.begin_s) & (truth.time_s < swing.end_s)
    time_s, q = truth.time_s[inside], truth.deflection_m[inside]
    up = np.flatnonzero((q[:-1] < 0.0) & (q[1:] >= 0.0))
    return float(np.median(np.diff(time_s[up]))) if len(up) > 2 else 0.5


def visible_amplitude(truth: TrueRun, swing: Swing, at_s: Values) -> tuple[NDArray[np.bool_], Values]:
    """Where the swing is visible, and the true amplitude there, m, at the given times."""
    inside = (truth.time_s >= swing.begin_s) & (truth.time_s < swing.end_s)
    time_s, q = truth.time_s[inside], np.abs(truth.deflection_m[inside])
    if len(q) < 2:
        return np.zeros(len(at_s), bool), np.ones(len(at_s))
    half = max(1, round(0.5 * period_s(truth) / (time_s[1] - time_s[0])))
    padded = np.pad(q, half, mode="edge")
    amplitude = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1).max(axis=1)
    least = _VISIBLE * float(amplitude.max())
    there = np.interp(at_s, time_s, amplitude, left=0.0, right=0.0)
    within = (at_s >= swing.begin_s) & (at_s < swing.end_s)
    return within & (there > least), np.maximum(there, least)


def _normalised(
    at_s: Values, error: Values, std: Values, visible: NDArray[np.bool_], swing: Swing
) -> list[float]:
    values = []
    for begin in np.arange(swing.begin_s, swing.end_s, _WINDOW_S):
        window = visible & (at_s >= max(begin, swing.begin_s + _ERROR_FROM_S)) & (at_s < begin + _WINDOW_S)
        window &= np.isfinite(error) & (std > 0.0)
        if np.sum(window) >= _FEWEST:
            values.append(float(np.mean((error[window] / std[window]) ** 2)))
    return values


def settled_s(at_s: Values, relative: Values, begin_s: float) -> float | None:
    """From `begin_s` until the running mean of `relative` over 0.25 s stays below 2 %; None for too few values."""
    if len(at_s) <= 10:
        return None
    n = max(1, round(_SETTLED_OVER_S / float(np.median(np.diff(at_s)))))
    if n > len(at_s):
        return None
    running = np.convolve(relative, np.full(n, 1.0 / n), mode="valid")
    above = np.flatnonzero(running > _SETTLED)
    return float(at_s[min(above[-1] + n, len(at_s) - 1)] - begin_s) if len(above) else 0.0


def longest_beyond_s(
    said: Estimates, error: Values, truth: TrueRun, begin_s: float, end_s: float = inf
) -> float | None:
    """The longest time beyond two stated deviations; None for a method that states none."""
    judged = (
        (said.time_s >= begin_s) & (said.time_s < end_s) & np.isfinite(error) & (said.deflection_std_m > 0.0)
    )
    if not judged.any():
        return None
    beyond = said.time_s[judged & (np.abs(error) > _BEYOND * said.deflection_std_m)]
    if not len(beyond):
        return 0.0
    breaks = np.flatnonzero(np.diff(beyond) > 0.5 * period_s(truth))
    first, last = np.concatenate(([0], breaks + 1)), np.concatenate((breaks, [len(beyond) - 1]))
    return float(np.max(beyond[last] - beyond[first]))


def _of(how: Callable[[Values], Any], values: Values) -> float | None:
    return float(how(values)) if len(values) else None
