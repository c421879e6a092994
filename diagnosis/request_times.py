"""When a triggered camera's frames were asked for: where the requests leave their interval, their clock was set."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.measured import Measured
from diagnosis.robust import std_about_zero

Array = NDArray[np.float64]


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
