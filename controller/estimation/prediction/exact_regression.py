"""The exact form of the sine regression [1]: the frequency is fitted too.

3 to 20 frames are less than a period, so that the samples alone hardly distinguish frequency, phase and a remaining
offset. The model's frequency is therefore a prior, and the fit gives the most probable frequency (Gauss-Newton on the
residual with amplitude and phase eliminated, the variable projection of Golub and Pereyra, SIAM J. Numer. Anal. 10,
1973, in Kaufman's simplification). Without information the prior's frequency stays.
"""

from math import hypot, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.model import Mode

_EVALUATIONS = 3  # at most two steps; a third would have no relevant effect
_SETTLED = 0.02  # of the prior's spread
_REACH = 3.0  # standard deviations of the prior
_FEW = 6  # samples: with fewer, their scatter is not estimated

Values = NDArray[np.float64]


class ExactFit(NamedTuple):
    """exp(-zeta w t)(a cos wd t + b sin wd t): a, b in m, w in rad/s, with their uncertainties.

    covariance: (aa, bb, ab) at the fitted w, m^2. angular_frequency_variance: of w, (rad/s)^2.
    a_per_w, b_per_w: sensitivity of a and b to w, m s/rad.
    """

    a: float
    b: float
    angular_frequency: float
    covariance: tuple[float, float, float]
    angular_frequency_variance: float
    a_per_w: float
    b_per_w: float


class _Trial(NamedTuple):
    """The best amplitude and phase at one frequency."""

    w: float
    a: float
    b: float
    inverse: tuple[float, float, float]
    residual: Values
    slope: Values  # derivative of the residual by w, with a and b refitted
    a_per_w: float
    b_per_w: float


class ExactRegression:
    """Fits one decaying sine of nearly known frequency to a few samples."""

    def __init__(self, mode: Mode, noise_std_m: float, dating_std_s: float, frequency_std: float) -> None:
        """noise_std_m, dating_std_s: errors of the samples in value and time; frequency_std: relative."""
        self._w = mode.angular_frequency
        self._zeta = mode.damping_ratio
        self._turn = sqrt(1.0 - mode.damping_ratio**2)
        self._noise = noise_std_m
        self._dating = dating_std_s
        self._spread = frequency_std * self._w

    def fit(self, t: Values, values: Values) -> ExactFit:
        """The most probable sine through `values` (m) at the times `t` (s), both of shape (n,), n >= 3."""
        best = self._at(self._w, t, values)
        variance = self._noise_variance(best)
        least = self._cost(best, variance)
        trial = best
        for _ in range(_EVALUATIONS - 1):
            w = self._stepped(trial, variance)
            if abs(w - trial.w) < _SETTLED * self._spread:
                break
            trial = self._at(w, t, values)
            cost = self._cost(trial, variance)
            if cost < least:
                best, least = trial, cost
        aa, bb, ab = best.inverse
        known = float(best.slope @ best.slope) / variance + 1.0 / self._spread**2
        return ExactFit(
            best.a,
            best.b,
            best.w,
            (aa * variance, bb * variance, ab * variance),
            1.0 / known,
            best.a_per_w,
            best.b_per_w,
        )

    def _at(self, w: float, t: Values, values: Values) -> _Trial:
        decay = np.exp(-self._zeta * w * t)
        angle = self._turn * w * t
        c, s = decay * np.cos(angle), decay * np.sin(angle)
        cc, ss, cs = float(c @ c), float(s @ s), float(c @ s)
        determinant = max(cc * ss - cs * cs, 1e-9 * cc * cc)

        def solved(y: Values) -> tuple[float, float]:
            cy, sy = float(c @ y), float(s @ y)
            return (ss * cy - cs * sy) / determinant, (cc * sy - cs * cy) / determinant

        a, b = solved(values)
        sine = a * c + b * s
        by_w = t * (self._turn * (b * c - a * s) - self._zeta * sine)
        a_taken, b_taken = solved(by_w)
        inverse = (ss / determinant, cc / determinant, -cs / determinant)
        slope = by_w - a_taken * c - b_taken * s
        return _Trial(w, a, b, inverse, values - sine, slope, -a_taken, -b_taken)

    def _noise_variance(self, trial: _Trial) -> float:
        """Scatter of the samples, m^2, without the part from a wrong frequency; at least their known variance."""
        least = max(self._noise, 1e-9)
        count = len(trial.residual)
        if count < _FEW:  # too few to estimate their scatter
            of_dating = self._w * self._dating * hypot(trial.a, trial.b) / sqrt(2.0)
            return least**2 + of_dating**2
        of_frequency = float(trial.slope @ trial.residual) ** 2 / max(
            float(trial.slope @ trial.slope), 1e-300
        )
        scatter = (float(trial.residual @ trial.residual) - of_frequency) / (count - 3)
        return max(scatter, least**2)

    def _cost(self, trial: _Trial, variance: float) -> float:
        """Minus twice the log probability, without a constant."""
        return float(trial.residual @ trial.residual) / variance + ((trial.w - self._w) / self._spread) ** 2

    def _stepped(self, trial: _Trial, variance: float) -> float:
        known = float(trial.slope @ trial.slope) / variance + 1.0 / self._spread**2
        pull = float(trial.slope @ trial.residual) / variance - (trial.w - self._w) / self._spread**2
        reach = _REACH * self._spread
        return min(max(trial.w + pull / known, self._w - reach), self._w + reach)
