"""On-line sine regression over the last 3 to 20 frames, evaluated at the present [1]: the simplified form.

The frequency is given (the model's); what is fitted is the free vibration, a decaying sine. Its answer to the joint's own motion
is known from the drive model, is taken off the samples before the fit and added again after: so the fit holds
while the joint moves or damps, when the deflection itself is no sine.
"""

from collections import deque
from math import cos, exp, hypot, nan, sin, sqrt
from typing import NamedTuple

import numpy as np

from common.model import Mode


class FreeVibration(NamedTuple):
    """Free deflection and its rate at an instant, with the fit's standard deviation."""

    deflection_m: float
    rate_m_s: float
    std_m: float
    amplitude_m: float


class SineRegression:
    """Least squares of exp(-zeta w t) (a cos wd t + b sin wd t), t counted back from the newest sample."""

    def __init__(self, mode: Mode, frames: int, noise_std_m: float) -> None:
        """Fit over `frames` samples; `noise_std_m` is the least that a sample is believed to be off."""
        self._zeta_w = mode.damping_ratio * mode.angular_frequency
        self._wd = mode.angular_frequency * sqrt(1.0 - mode.damping_ratio**2)
        self._noise = noise_std_m
        self._times: deque[float] = deque(maxlen=frames)
        self._values: deque[float] = deque(maxlen=frames)
        self._reference = nan
        self._a = self._b = 0.0
        self._covariance = (0.0, 0.0, 0.0)

    @property
    def ready(self) -> bool:
        """Whether a fit exists."""
        return len(self._times) >= 3

    def restart(self) -> None:
        """Forget all samples."""
        self._times.clear()
        self._values.clear()

    def add(self, time_s: float, free_deflection_m: float, longest_gap_s: float) -> None:
        """Take in one sample at its capture time; a gap longer than `longest_gap_s`, or a step back, starts afresh."""
        if self._times and not 0.0 <= time_s - self._times[-1] <= longest_gap_s:
            self.restart()
        self._times.append(time_s)
        self._values.append(free_deflection_m)
        if self.ready:
            self._fit()

    def _fit(self) -> None:
        times = np.array(self._times)
        values = np.array(self._values)
        self._reference = self._times[-1]
        t = times - self._reference
        decay = np.exp(-self._zeta_w * t)
        c, s = decay * np.cos(self._wd * t), decay * np.sin(self._wd * t)
        cc, ss, cs = float(c @ c), float(s @ s), float(c @ s)
        determinant = max(cc * ss - cs * cs, 1e-12 * cc * max(ss, 1e-12))
        cy, sy = float(c @ values), float(s @ values)
        self._a = (ss * cy - cs * sy) / determinant
        self._b = (cc * sy - cs * cy) / determinant
        residual = values - self._a * c - self._b * s
        freedom = max(1, len(times) - 2)
        variance = max(float(residual @ residual) / freedom, self._noise**2) / determinant
        self._covariance = (ss * variance, cc * variance, -cs * variance)

    def predict(self, time_s: float) -> FreeVibration:
        """The free vibration at an instant, from the last fit. Call only when ready."""
        t = time_s - self._reference
        decay, c, s = exp(-self._zeta_w * t), cos(self._wd * t), sin(self._wd * t)
        deflection = decay * (self._a * c + self._b * s)
        rate = decay * self._wd * (self._b * c - self._a * s) - self._zeta_w * deflection
        aa, bb, ab = self._covariance
        variance = decay * decay * (c * c * aa + s * s * bb + 2.0 * c * s * ab)
        return FreeVibration(deflection, rate, sqrt(max(variance, 0.0)), decay * hypot(self._a, self._b))
