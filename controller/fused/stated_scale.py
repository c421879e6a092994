"""The image scale that the model states, weighed against what the sensors say of it.

The filters take it for uncertain by as much as another scene may make it. But a calibrated model mostly has it to a
percent, which the accelerometer needs seconds to tell as well. So beforehand the scale's relative error e is taken,
with even odds, for N(0, s^2) (as stated) or N(0, v) (as the filters take it). They make e = m +- sqrt(P) of v, so that
the measurements alone say y +- sqrt(R) with 1 / R = 1 / P - 1 / v, y = m R / P; by them the odds of `as stated` are

    N(y; 0, R + s^2) / N(y; 0, R + v)

and in that case e has one more measurement, of value 0 and variance r with 1 / r = 1 / s^2 - 1 / v. What is told is
the mixture (Bar-Shalom, Li and Kirubarajan, Estimation with Applications, 2001, section 1.4.16). The filters know
nothing of it: it is told anew each time and is never counted twice.
"""

from math import exp, sqrt

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_STATED = 0.01**2  # variance: `stillarm calibrate` asks for 2 % of each scale and comes to some tenths
_TOLD = 0.5  # of the variance beforehand: above it, the sensors have said too little to judge by
_SETTLED = 0.04  # of _STATED: below it, they know it too well for the model to add anything


def odds_as_stated(mean: float, variance: float, first: float) -> float:
    """Of an error of the scale as the filters have it, who took it for N(0, first) beforehand; variance below first."""
    own = 1.0 / (1.0 / variance - 1.0 / first)
    square = (mean * own / variance) ** 2
    narrow, wide = own + _STATED, own + first
    return sqrt(wide / narrow) * exp(0.5 * square * (1.0 / wide - 1.0 / narrow))


def with_stated_scale(x: Array, p: Array, scale: int, first: float) -> tuple[Array, Array]:
    """State (n,) and covariance (n, n) once the model's word on the scale counts; x[scale]: its relative error.

    first: the filters' variance of it beforehand.
    """
    mean, variance = float(x[scale]), float(p[scale, scale])
    if not _SETTLED * _STATED < variance < _TOLD * first:
        return x, p
    odds = odds_as_stated(mean, variance, first)
    probability = odds / (1.0 + odds)
    total = variance + 1.0 / (1.0 / _STATED - 1.0 / first)
    gain = p[scale] / total
    spread = (1.0 - probability) * mean * mean  # between the two cases
    return x - (probability * mean) * gain, p - (probability * (total - spread)) * np.outer(gain, gain)
