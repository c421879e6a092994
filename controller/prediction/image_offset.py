"""The image's slowly changing zero: a recursive fit of offset and oscillation with a long memory."""

from math import cos, exp, sin, sqrt

import numpy as np

from common.model import Mode


class ImageOffset:
    """Offset c of samples c + A cos + B sin of one decaying mode, by least squares with exponential forgetting.

    The quadratures are carried along with the oscillation from sample to sample, so that the regressors are always
    (1, 1, 0): a Kalman filter with fading memory (Anderson and Moore, Optimal Filtering, 1979, section 6.2).
    """

    _PRIOR_VARIANCE = 1.0  # m^2: nothing is known before the first sample

    def __init__(self, mode: Mode, memory_s: float) -> None:
        """Forget with time constant `memory_s`."""
        self._w = mode.angular_frequency
        self._zeta = mode.damping_ratio
        self._memory_s = memory_s
        self._state = np.zeros(3)
        self._covariance = np.eye(3) * self._PRIOR_VARIANCE
        self._time_s: float | None = None

    @property
    def offset_m(self) -> float:
        """The offset as known now, m."""
        return float(self._state[0])

    def forget_vibration(self) -> None:
        """The arm was struck: the offset stays as well known as it was, the oscillation is unknown."""
        self._covariance[1:, 1:] = np.eye(2) * self._PRIOR_VARIANCE
        self._covariance[0, 1:] = self._covariance[1:, 0] = 0.0

    def add(self, time_s: float, value_m: float) -> None:
        """Take in one sample; times should increase, a step back counts as none at all."""
        elapsed = 0.0 if self._time_s is None else max(0.0, time_s - self._time_s)
        self._time_s = time_s
        angle = self._w * sqrt(1.0 - self._zeta * self._zeta) * elapsed
        decay = exp(-self._zeta * self._w * elapsed)
        c, s = decay * cos(angle), decay * sin(angle)
        turn = np.array(((1.0, 0.0, 0.0), (0.0, c, s), (0.0, -s, c)))
        state = turn @ self._state
        covariance = turn @ self._covariance @ turn.T
        room = max(1.0, self._PRIOR_VARIANCE / float(covariance.diagonal().max()))
        covariance *= min(exp(min(elapsed / self._memory_s, 50.0)), room)
        seen = covariance[:, 0] + covariance[:, 1]
        noise = 1e-6  # m^2; only its ratio to the prior matters
        gain = seen / (seen[0] + seen[1] + noise)
        self._state = state + gain * (value_m - state[0] - state[1])
        covariance -= np.outer(gain, seen)
        self._covariance = 0.5 * (covariance + covariance.T)
