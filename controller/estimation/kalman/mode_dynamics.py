"""A bending mode's free motion over any time, in closed form: its transition and its process noise."""

from math import cos, exp, expm1, sin, sqrt
from typing import NamedTuple

from stillarm.common.files.model import Mode


class Transition(NamedTuple):
    """Deflection and rate after a time: q = qq q0 + qv v0, v = vq q0 + vv v0."""

    qq: float
    qv: float
    vq: float
    vv: float


class Scatter(NamedTuple):
    """Covariance of deflection and rate: qq m^2, qv m^2/s, vv m^2/s^2."""

    qq: float
    qv: float
    vv: float


_NO_DAMPING = 1e-200  # 1/s: below it the quotient loses precision, and equals t to many more digits


class ModeDynamics:
    """q'' + 2 zeta w q' + w^2 q = white acceleration."""

    def __init__(self, mode: Mode) -> None:
        """mode: a mode of the model."""
        w = mode.angular_frequency
        self.angular_frequency = w
        self._a = mode.damping_ratio * w
        self._b = w * sqrt(1.0 - mode.damping_ratio**2)

    def transition(self, elapsed_s: float) -> Transition:
        """The transition over a time of either sign."""
        a, b, w = self._a, self._b, self.angular_frequency
        decay, angle = exp(-a * elapsed_s), b * elapsed_s
        c, s = decay * cos(angle), decay * sin(angle) / b
        return Transition(c + a * s, s, -w * w * s, c - a * s)

    def scatter(self, elapsed_s: float) -> Scatter:
        """Covariance that a white acceleration of spectral density 1 m^2/s^3 adds over a time >= 0.

        With the impulse response h(s) = exp(-a s) sin(b s) / b: the integrals of h^2, h h' and h'^2 from 0 to elapsed_s
        (Jazwinski, Stochastic Processes and Filtering Theory, 1970, section 7.2).
        """
        a, b, t = self._a, self._b, elapsed_s
        decay = exp(-2.0 * a * t)
        even = -expm1(-2.0 * a * t) / (2.0 * a) if a > _NO_DAMPING else t  # of exp(-2 a s)
        norm = 2.0 * (a * a + b * b)  # of exp(-2 a s) cos 2 b s and exp(-2 a s) sin 2 b s
        cosine = (a + decay * (b * sin(2.0 * b * t) - a * cos(2.0 * b * t))) / norm
        sine = (b - decay * (b * cos(2.0 * b * t) + a * sin(2.0 * b * t))) / norm
        less, more, ratio = 0.5 * (even - cosine), 0.5 * (even + cosine), a / b
        response = exp(-a * t) * sin(b * t) / b
        return Scatter(
            max(0.0, less / (b * b)), 0.5 * response * response, more - ratio * sine + ratio * ratio * less
        )
