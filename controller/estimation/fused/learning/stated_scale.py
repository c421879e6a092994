"""The image scale that the model states, weighed against what the sensors say of it.

Implements Eq. 41 of docs/fused.md.

The filters' prior allows for another scene. But a calibrated model mostly knows the scale to a percent, and a
commissioned one states how well; the accelerometer needs seconds to learn as much. The prior of the scale's relative
error e is therefore N(0, s^2) (as stated) or N(0, v) (as in the filters), at odds of o: even, and nine to one for a
commissioned model, whose scale was measured on this rig. They make e = m +- sqrt(P) of v, so that the measurements
alone say y +- sqrt(R) with 1 / R = 1 / P - 1 / v, y = m R / P; by them the odds of `as stated` are

    o N(y; 0, R + s^2) / N(y; 0, R + v)

and in that case e has one more measurement, of value 0 and variance r with 1 / r = 1 / s^2 - 1 / v. The result is
the mixture (Bar-Shalom, Li and Kirubarajan, Estimation with Applications, 2001, section 1.4.16). The filters know
nothing of it: it is computed anew each time, and no measurement is counted twice.
"""

from math import exp, hypot, sqrt
from typing import NamedTuple

import numpy as np
from msgspec import UnsetType
from numpy.typing import NDArray

from stillarm.common.files.model import Model
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS
from stillarm.controller.estimation.fused.assumptions.filter_assumptions import ScaleAssumptions

Array = NDArray[np.float64]


class Stated(NamedTuple):
    """What a model says of the image's scale relative to the accelerometer's. variance: of its relative error; odds: of
    that against what the filters take it for, before anything is seen."""

    variance: float
    odds: float


def stated_scale(model: Model, first: float, assumed: ScaleAssumptions = ASSUMPTIONS.scale) -> Stated:
    """The deviations that the model file states. Their variance is bounded well below `first`, the filters' prior;
    otherwise there would be nothing to weigh.
    """
    std = {} if isinstance(model.commissioned, UnsetType) else model.commissioned.std
    stated = {
        "camera.scale_px_per_m": model.camera.scale_px_per_m,
        "accelerometer.scale": model.accelerometer.scale,
    }
    if not stated.keys() <= std.keys():
        return Stated(assumed.by_hand**2, assumed.even_odds)
    of_each = [std[name] / value for name, value in stated.items()]
    return Stated(
        float(min(max(assumed.least, hypot(*of_each)) ** 2, assumed.told * first)), assumed.commissioned_odds
    )


def odds_as_stated(mean: float, variance: float, first: float, stated: Stated) -> float:
    """Odds of `as stated` for the filters' error of the scale, whose prior was N(0, first); variance below first."""
    own = 1.0 / (1.0 / variance - 1.0 / first)
    square = (mean * own / variance) ** 2
    narrow, wide = own + stated.variance, own + first
    return stated.odds * sqrt(wide / narrow) * exp(0.5 * square * (1.0 / wide - 1.0 / narrow))


def with_stated_scale(
    x: Array,
    p: Array,
    scale: int,
    first: float,
    stated: Stated,
    assumed: ScaleAssumptions = ASSUMPTIONS.scale,
) -> tuple[Array, Array]:
    """State (n,) and covariance (n, n) once the model's word on the scale counts; x[scale]: its relative error.

    first: the filters' variance of it beforehand.
    """
    mean, variance = float(x[scale]), float(p[scale, scale])
    if not assumed.settled * stated.variance < variance < assumed.told * first:
        return x, p
    odds = odds_as_stated(mean, variance, first, stated)
    probability = odds / (1.0 + odds)
    total = variance + 1.0 / (1.0 / stated.variance - 1.0 / first)
    gain = p[scale] / total
    spread = (1.0 - probability) * mean * mean  # between the two cases
    return x - (probability * mean) * gain, p - (probability * (total - spread)) * np.outer(gain, gain)
