"""On-line sine regression over the last 3 to 20 frames, evaluated at the present [1].

In the simplified form the frequency is given (the model's). In the exact form (exact_regression.py) it is fitted. The
fit is of the free vibration, a decaying sine. The arm's response to the joint's own motion is known from the drive
model. It is subtracted from the samples before the fit and added again afterwards. The fit is therefore valid while the
joint moves or damps and the deflection itself is no sine.

The window may have a variable length. It grows to `frames` samples, and is cut down to the newest one if that is
further from the fit's prediction than noise and the delay's spread explain, as after an impact. A window of fixed
length takes `frames` samples to forget an impact.
"""

from collections import deque
from math import cos, exp, hypot, nan, sin, sqrt
from typing import NamedTuple

import numpy as np

from stillarm.common.files.model import Mode
from stillarm.controller.estimation.prediction.exact_regression import ExactFit, ExactRegression

_CHANGE_STDS = 4.0  # one false alarm in some minutes at the frame rate; an impact exceeds it at once

_FEW = 6  # samples: with fewer, their scatter is not estimated


class FreeVibration(NamedTuple):
    """Free deflection and its rate at an instant, with the fit's standard deviation."""

    deflection_m: float
    rate_m_s: float
    std_m: float
    amplitude_m: float


class SineRegression:
    """Least squares of exp(-zeta w t) (a cos wd t + b sin wd t), t counted back from the newest sample."""

    def __init__(
        self,
        mode: Mode,
        frames: int,
        noise_std_m: float,
        dating_std_s: float,
        *,
        variable_window: bool = True,
        exact: ExactRegression | None = None,
    ) -> None:
        """Fit over up to `frames` samples with errors of `noise_std_m` in value and `dating_std_s` in time.

        variable_window: whether an impact cuts the window. exact: also fits the frequency; None: it is given.
        """
        self._w = mode.angular_frequency
        self._zeta_w = mode.damping_ratio * self._w
        self._wd = self._w * sqrt(1.0 - mode.damping_ratio**2)
        self._noise = noise_std_m
        self._dating = dating_std_s
        self._times: deque[float] = deque(maxlen=frames)
        self._values: deque[float] = deque(maxlen=frames)
        self._reference = nan
        self._a = self._b = 0.0
        self._covariance = (0.0, 0.0, 0.0)
        self._variable_window = variable_window
        self._exact = exact
        self._turn, self._zeta = sqrt(1.0 - mode.damping_ratio**2), mode.damping_ratio
        self._frequency_variance = self._a_per_w = self._b_per_w = 0.0
        self.ready = False

    @property
    def samples(self) -> int:
        """Number of samples in the window."""
        return len(self._times)

    def restart(self) -> None:
        """Forget all samples. The last fit remains until there are three new ones."""
        self._times.clear()
        self._values.clear()

    def add(
        self,
        time_s: float,
        value_m: float,
        offset_m: float,
        longest_gap_s: float,
        known_rate_m_s: float = 0.0,
        offset_std_m: float = 0.0,
    ) -> bool:
        """Add one sample at its capture time; `offset_m` is subtracted from all samples of the window.

        known_rate_m_s: rate of the motion that was subtracted from the image, in proportion to which a dating error
        causes an error. offset_std_m: standard deviation of the offset.
        A gap longer than `longest_gap_s` restarts the window. Times may go back slightly, since the delay that dates
        them is only an estimate. Returns whether the sample contradicts the fit, as after an impact.
        """
        if self._times and abs(time_s - self._times[-1]) > longest_gap_s:
            self.restart()
        changed = (
            self._variable_window
            and self.samples >= 3
            and self._changed(time_s, value_m - offset_m, known_rate_m_s, offset_std_m)
        )
        if changed:
            self.restart()
        self._times.append(time_s)
        self._values.append(value_m)
        if self.samples >= 3:
            self._fit(offset_m)
        return changed

    def _changed(self, time_s: float, value_m: float, known_rate_m_s: float, offset_std_m: float) -> bool:
        expected = self.predict(time_s)
        of_dating = self._dating * (abs(expected.rate_m_s) + abs(known_rate_m_s))
        of_bend = 0.5 * expected.amplitude_m * (self._w * self._dating) ** 2  # at zero rate
        spread = hypot(expected.std_m, self._noise, of_dating, of_bend, offset_std_m)
        return abs(value_m - expected.deflection_m) > _CHANGE_STDS * spread

    def _fit(self, offset_m: float) -> None:
        self._reference = self._times[-1]
        if self._exact is not None:
            t = np.array(self._times) - self._reference
            return self._take(self._exact.fit(t, np.array(self._values) - offset_m))
        values = [value - offset_m for value in self._values]
        waves = [self._wave(time_s - self._reference) for time_s in self._times]
        cc = ss = cs = cy = sy = 0.0  # scalars: the arrays are too short for numpy to pay
        for (c, s), y in zip(waves, values, strict=True):
            cc += c * c
            ss += s * s
            cs += c * s
            cy += c * y
            sy += s * y
        if len(values) < _FEW:
            ridge = self._ridge(max(map(abs, values)))
            cc, ss = cc + ridge, ss + ridge
        determinant = max(cc * ss - cs * cs, 1e-9 * cc * cc)
        a = self._a = (ss * cy - cs * sy) / determinant
        b = self._b = (cc * sy - cs * cy) / determinant
        squares = 0.0
        for (c, s), y in zip(waves, values, strict=True):
            residual = y - a * c - b * s
            squares += residual * residual
        least = self._noise
        if len(values) < _FEW:  # too few to estimate their scatter
            least = hypot(least, self._w * self._dating * hypot(a, b) / sqrt(2.0))
        variance = max(squares / max(1, len(values) - 2), least * least) / determinant
        self._covariance = (ss * variance, cc * variance, -cs * variance)
        self.ready = True
        return None

    def _wave(self, t: float) -> tuple[float, float]:
        """The two decaying waves at a time relative to the newest sample."""
        decay, angle = exp(-self._zeta_w * t), self._wd * t
        return decay * cos(angle), decay * sin(angle)

    def _ridge(self, largest_m: float) -> float:
        """A prior on a and b, for short windows in which samples with almost equal times leave their slope
        undetermined.

        Noise variance of a sample over the variance of an amplitude some 1.5 times the largest observed value.
        """
        noise = self._noise**2 + 0.5 * (self._w * self._dating * largest_m) ** 2
        return noise / max((1.5 * largest_m) ** 2, self._noise**2, 1e-30)

    def _take(self, fit: ExactFit) -> None:
        self._a, self._b, self._covariance = fit.a, fit.b, fit.covariance
        self._wd = self._turn * fit.angular_frequency
        self._zeta_w = self._zeta * fit.angular_frequency
        self._frequency_variance = fit.angular_frequency_variance
        self._a_per_w, self._b_per_w = fit.a_per_w, fit.b_per_w
        self.ready = True

    def predict(self, time_s: float) -> FreeVibration:
        """The free vibration at an instant, from the last fit. Call only when ready."""
        t = time_s - self._reference
        decay, c, s = exp(-self._zeta_w * t), cos(self._wd * t), sin(self._wd * t)
        deflection = decay * (self._a * c + self._b * s)
        rate = decay * self._wd * (self._b * c - self._a * s) - self._zeta_w * deflection
        aa, bb, ab = self._covariance
        variance = decay * decay * (c * c * aa + s * s * bb + 2.0 * c * s * ab)
        if self._frequency_variance > 0.0:
            turned = self._turn * (self._b * c - self._a * s) * decay - self._zeta * deflection
            by_w = t * turned + decay * (self._a_per_w * c + self._b_per_w * s)
            variance += by_w * by_w * self._frequency_variance
        return FreeVibration(deflection, rate, sqrt(max(variance, 0.0)), decay * hypot(self._a, self._b))
