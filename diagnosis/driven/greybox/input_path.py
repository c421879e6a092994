"""The input's way to the joint: a dead zone, a limit, a delay, and a lag of first order."""

from math import exp

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from stillarm.diagnosis.driven.greybox.laws import Numbers
from stillarm.diagnosis.driven.recording.signals import Driven

Array = NDArray[np.float64]

STEADY = "steady"
"""The input before the first sample, over the first: 1 where a lag has settled at it, 0 where the drive was off."""
OF_INPUT = ("dead_zone", "dead_cut", "limit", "delay", "held", "lag", STEADY)
"""The numbers of this way."""
_CUT_OVER = 0.1  # of the width: over which a dead zone opens, so that a derivative by the width is one


def reaching(driven: Driven, numbers: Numbers, parts: int) -> Array:
    """What reaches the joint at the start and the end of each substep, (n parts, 2), in the input's unit."""
    h = driven.step_s
    u = driven.u
    zone, limit = numbers.get("dead_zone", 0.0), numbers.get("limit", 0.0)
    if zone > 0.0:
        u = np.sign(u) * np.maximum(np.abs(u) - zone, 0.0)
    cut = numbers.get("dead_cut", 0.0)
    if cut > 0.0:
        u = u * np.clip((np.abs(u) - cut) / (_CUT_OVER * cut) + 0.5, 0.0, 1.0)
    if limit > 0.0:
        u = np.clip(u, -limit, limit)
    step, before = h / parts, numbers.get(STEADY, 1.0) * u[0]
    fine = np.arange(driven.samples * parts + 1) * step - numbers.get("delay", 0.0)
    if numbers.get("held", 0.0):
        # the mean over each substep, wherever the input changes within it
        passed = np.concatenate([[0.0], np.cumsum(u) * h])
        whole = np.interp(fine, np.arange(driven.samples + 1) * h, passed) + before * np.minimum(fine, 0.0)
        begin = end = np.diff(whole) / step
    else:
        at = np.interp(fine, np.arange(-1, driven.samples) * h, np.concatenate([[before], u]))
        begin, end = at[:-1], at[1:]
    lag = numbers.get("lag", 0.0)
    if lag > 1e-3 * step:
        keep = exp(-step / lag)
        # exact for an input that is linear over the substep
        late = 1.0 - lag / step * (1.0 - keep)
        fed = late * end + (1.0 - keep - late) * begin
        after = lfilter([1.0], [1.0, -keep], fed - (1.0 - keep) * before) + before
        begin, end = np.concatenate([[before], after[:-1]]), after
    return np.ascontiguousarray(np.column_stack([begin, end]))


def before_and_after(u: Array, parts: int) -> Array:
    """What reaches the joint just before each sample and just after, (2, n). u: at both ends of each substep."""
    after = u[::parts, 0]
    return np.stack([np.concatenate([after[:1], u[parts - 1 :: parts, 1][:-1]]), after])
