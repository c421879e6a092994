"""When a triggered camera's frames were asked for: where the requests leave their interval, their clock was set, or
where by whole intervals, frames never came."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.measured import Frames, Measured
from stillarm.diagnosis.robust import std_about_median, std_about_zero

Array = NDArray[np.float64]

_REGULAR = 0.1  # of the interval: what requests that keep one may scatter by
_WHOLE, _SELDOM = 0.25, 0.1  # intervals off a whole number of them; the share that may be further off


@dataclass(frozen=True)
class Intervals:
    """By how much each request came off its interval after the last, (frames - 1,) s, and how much is usual, s."""

    off_s: Array
    usual_s: float


def request_intervals(measured: Measured) -> Intervals:
    """The intervals of a recording's requests. They are noted to the cycle, so that no less than one is usual."""
    between = np.diff(measured.frames.started_s)
    off = between - float(np.median(between))
    return Intervals(off, std_about_zero(off) + measured.cycle_s)


def missing_requests(frames: Frames) -> NDArray[np.int64] | None:
    """How many frames never came between each and the next, (frames - 1,): what the counter skips, or whole intervals
    that a triggered camera's stamps or requests leave out. None where neither keeps an interval."""
    skipped = np.diff(frames.counter) - 1
    if np.any(skipped > 0) and np.all(skipped >= 0):
        return skipped
    for times in (frames.captured_s, frames.started_s):
        between = np.diff(times)
        if len(between) == 0 or not np.isfinite(between).all():
            continue
        between = between / float(np.median(between))
        whole = np.rint(between).astype(np.int64)
        off = np.abs(between - whole) > _WHOLE
        if std_about_median(between) < _REGULAR and float(np.mean(off)) < _SELDOM:
            return np.maximum(whole - 1, 0)
    return None
