"""Standard deviations and steps that a few outliers do not move: from medians, and from the median absolute deviation
(Hampel, Journal of the American Statistical Association 69, 1974), which for normal values is the standard deviation
over 1.4826; and missing values bridged."""

from math import comb

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

OUTLYING = 6.0
"""Robust deviations beyond which a value is an outlier: of normal values two in a thousand million are."""

MIN_USUAL = 100
"""Values that tell how much is usual: the median absolute deviation of as many normal ones is right to 12 %."""

SIDE = 15
"""Values on either side of a step: their medians tell it to 1.25 sqrt(2 / 15), under half of the values' scatter."""

WHOLE = 0.25
"""Off a whole number of frames or intervals, within which it is taken for that number: half the way to where the next
is as near."""

_MAD_TO_STD = 1.4826  # 1 / 0.6745: half of normal values lie within 0.6745 deviations
_ABOUT_A_SPIKE = 5  # samples, of which a spike of two is the lesser part


def std_about_zero(values: Array) -> float:
    """Of values whose middle is known to be zero. values: (n,), n > 0, none missing."""
    return _MAD_TO_STD * float(np.median(np.abs(values)))


def std_about_median(values: Array) -> float:
    """Of values about their own median. values: (n,), n > 0, none missing."""
    return std_about_zero(values - np.median(values))


def step_at(values: Array, index: int, side: int) -> float:
    """By how much the median of up to `side` values from `index` on exceeds that of as many before it; unknown ones,
    NaN, are left out."""
    return float(
        np.nanmedian(values[index : index + side]) - np.nanmedian(values[max(0, index - side) : index])
    )


def in_differences(order: int) -> float:
    """Standard deviation of white noise in differences of an order, over its own: sqrt(binomial(2 order, order))."""
    return float(comb(2 * order, order) ** 0.5)


def white_noise(values: Array, order: int = 4) -> float:
    """Standard deviation of what changes from sample to sample, by differences of an order, which hold next to nothing
    of a motion that is slow beside the samples; 0 where there are none. values: (n,), NaN where unknown."""
    differences = np.diff(values, order)
    differences = differences[np.isfinite(differences)]
    return std_about_zero(differences) / in_differences(order) if len(differences) else 0.0


def without_spikes(values: Array) -> Array:
    """Values in which each that is an outlier among the four about it is their median (Hampel's filter): what lasts for
    a sample or two is no motion. values: (n,); missing ones, NaN, stay, and are no neighbours."""
    known = np.isfinite(values)
    if not known.all():
        clean = values.copy()
        clean[known] = without_spikes(values[known])
        return clean
    if len(values) < _ABOUT_A_SPIKE:
        return values
    about = np.lib.stride_tricks.sliding_window_view(
        np.pad(values, _ABOUT_A_SPIKE // 2, mode="edge"), _ABOUT_A_SPIKE
    )
    middle = np.median(about, axis=1)
    off = values - middle
    return np.where(np.abs(off) > OUTLYING * std_about_zero(np.diff(values)), middle, values)


def bridged(values: Array) -> Array:
    """Values with the missing ones, NaN, on straight lines between their neighbours, (n,); empty where all are."""
    known = np.flatnonzero(np.isfinite(values))
    if not len(known):
        return np.empty(0)
    return np.interp(np.arange(len(values)), known, values[known])
