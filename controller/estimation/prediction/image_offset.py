"""The slowly changing image zero: a recursive fit of offset and oscillation with a long memory."""

from math import cos, exp, sin, sqrt

from stillarm.common.files.model import Mode

_NOISE_M2 = 1e-6  # of a sample; only its ratio to the prior matters


class ImageOffset:
    """Offset c of samples c + A cos + B sin of one decaying mode, by least squares with exponential forgetting.

    The quadratures rotate with the oscillation from sample to sample, so that the regressors are always (1, 1, 0): a
    Kalman filter with fading memory (Anderson and Moore, Optimal Filtering, 1979, section 6.2). It is written in
    scalars; with 3 x 3 matrices it takes five times as long.
    """

    _PRIOR_VARIANCE = 1.0  # m^2: no prior knowledge

    def __init__(self, mode: Mode, memory_s: float) -> None:
        """memory_s: time constant of the forgetting."""
        self._w = mode.angular_frequency
        self._zeta = mode.damping_ratio
        self._memory_s = memory_s
        self._offset = self._cosine = self._sine = 0.0
        # the covariance's upper triangle: offset, cosine, sine
        self._oo = self._cc = self._ss = self._PRIOR_VARIANCE
        self._oc = self._os = self._cs = 0.0
        self._time_s: float | None = None

    @property
    def offset_m(self) -> float:
        """The present estimate of the offset, m."""
        return self._offset

    @property
    def std_m(self) -> float:
        """Standard deviation of the offset, m."""
        return sqrt(max(self._oo, 0.0))

    def forget_vibration(self) -> None:
        """After an impact: keep the offset and its deviation, and make the oscillation unknown."""
        self._cc = self._ss = self._PRIOR_VARIANCE
        self._oc = self._os = self._cs = 0.0

    def doubt(self, spread_m: float) -> None:
        """Widen the offset's deviation: the zero may have moved, by a release of the arm or in the tracker."""
        self._oo = min(self._oo + spread_m * spread_m, self._PRIOR_VARIANCE)

    def add(self, time_s: float, value_m: float) -> None:
        """Add one sample. Times should increase; a step back counts as zero elapsed time."""
        elapsed = 0.0 if self._time_s is None else max(0.0, time_s - self._time_s)
        self._time_s = time_s
        self._carry_along(elapsed)
        self._forget(elapsed)
        # a sample shows offset + cosine part
        of_offset, of_cosine, of_sine = self._oo + self._oc, self._oc + self._cc, self._os + self._cs
        spread = of_offset + of_cosine + _NOISE_M2
        error = value_m - self._offset - self._cosine
        self._offset += of_offset / spread * error
        self._cosine += of_cosine / spread * error
        self._sine += of_sine / spread * error
        self._oo -= of_offset * of_offset / spread
        self._oc -= of_offset * of_cosine / spread
        self._os -= of_offset * of_sine / spread
        self._cc -= of_cosine * of_cosine / spread
        self._cs -= of_cosine * of_sine / spread
        self._ss -= of_sine * of_sine / spread

    def _carry_along(self, elapsed_s: float) -> None:
        """Rotate the quadratures and their covariance by the elapsed time."""
        angle = self._w * sqrt(1.0 - self._zeta * self._zeta) * elapsed_s
        decay = exp(-self._zeta * self._w * elapsed_s)
        c, s = decay * cos(angle), decay * sin(angle)
        self._cosine, self._sine = c * self._cosine + s * self._sine, c * self._sine - s * self._cosine
        self._oc, self._os = c * self._oc + s * self._os, c * self._os - s * self._oc
        cc, ss, cs = self._cc, self._ss, self._cs
        self._cc = c * c * cc + 2.0 * c * s * cs + s * s * ss
        self._ss = s * s * cc - 2.0 * c * s * cs + c * c * ss
        self._cs = c * s * (ss - cc) + (c * c - s * s) * cs

    def _forget(self, elapsed_s: float) -> None:
        """Fade the memory, but not beyond the prior."""
        room = max(1.0, self._PRIOR_VARIANCE / max(self._oo, self._cc, self._ss))
        more = min(exp(min(elapsed_s / self._memory_s, 50.0)), room)
        self._oo *= more
        self._oc *= more
        self._os *= more
        self._cc *= more
        self._cs *= more
        self._ss *= more
