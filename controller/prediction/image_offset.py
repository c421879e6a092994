"""The image's slowly changing zero: a recursive fit of offset and oscillation with a long memory."""

from math import cos, exp, sin, sqrt

from common.model import Mode

_NOISE_M2 = 1e-6  # of a sample; only its ratio to the prior matters


class ImageOffset:
    """Offset c of samples c + A cos + B sin of one decaying mode, by least squares with exponential forgetting.

    The quadratures are carried along with the oscillation from sample to sample, so that the regressors are always
    (1, 1, 0): a Kalman filter with fading memory (Anderson and Moore, Optimal Filtering, 1979, section 6.2).
    Written out in numbers: with matrices of three it takes five times as long.
    """

    _PRIOR_VARIANCE = 1.0  # m^2: nothing is known before the first sample

    def __init__(self, mode: Mode, memory_s: float) -> None:
        """Forget with time constant `memory_s`."""
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
        """The offset as known now, m."""
        return self._offset

    @property
    def std_m(self) -> float:
        """How well it is known, m."""
        return sqrt(max(self._oo, 0.0))

    def forget_vibration(self) -> None:
        """The arm was struck: the offset stays as well known as it was, the oscillation is unknown."""
        self._cc = self._ss = self._PRIOR_VARIANCE
        self._oc = self._os = self._cs = 0.0

    def doubt(self, spread_m: float) -> None:
        """The zero may have moved by that much: a bent arm was let go, or the tracker has another zero."""
        self._oo = min(self._oo + spread_m * spread_m, self._PRIOR_VARIANCE)

    def add(self, time_s: float, value_m: float) -> None:
        """Take in one sample; times should increase, a step back counts as none at all."""
        elapsed = 0.0 if self._time_s is None else max(0.0, time_s - self._time_s)
        self._time_s = time_s
        self._carry_along(elapsed)
        self._forget(elapsed)
        # what is seen is offset + cosine part
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
        """Turn the quadratures, and their covariance, on by what has passed."""
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
        """Fade the memory; what is not known at all does not become less known."""
        room = max(1.0, self._PRIOR_VARIANCE / max(self._oo, self._cc, self._ss))
        more = min(exp(min(elapsed_s / self._memory_s, 50.0)), room)
        self._oo *= more
        self._oc *= more
        self._os *= more
        self._cc *= more
        self._cs *= more
        self._ss *= more
