"""Standard deviations and steps that a few outliers do not move: from medians, and from the median absolute deviation
(Hampel, Journal of the American Statistical Association 69, 1974), which for normal values is the standard deviation
over 1.4826."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_MAD_TO_STD = 1.4826
OF_SECOND, OF_FIFTH = 6.0**0.5, 252.0**0.5  # white noise in second and fifth differences, over its own


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
