"""A bending mode's exact response to a joint acceleration that is constant over each cycle."""

from math import cos, exp, sin, sqrt

from stillarm.common.files.model import Mode


class ModalResponse:
    """q'' + 2 zeta w q' + w^2 q = - participation * length * theta'', from rest."""

    def __init__(self, mode: Mode, length_m: float, cycle_s: float) -> None:
        """Compute the mode's transition over one cycle."""
        w, zeta = mode.angular_frequency, mode.damping_ratio
        self._w, self._zeta, self._cycle_s = w, zeta, cycle_s
        self._qq, self._qv, self._vq, self._vv = self._transition(cycle_s)
        self._load = -mode.participation * length_m
        self._static = 1.0 / (w * w)
        self.deflection_m = 0.0
        self.rate_m_s = 0.0

    def _transition(self, elapsed_s: float) -> tuple[float, float, float, float]:
        """Transition of deflection and rate over a time: qq, qv, vq, vv."""
        w, zeta = self._w, self._zeta
        damped = w * sqrt(1.0 - zeta * zeta)
        decay, c, s = exp(-zeta * w * elapsed_s), cos(damped * elapsed_s), sin(damped * elapsed_s)
        qv = decay * s / damped
        return decay * (c + zeta * w / damped * s), qv, -w * w * qv, decay * (c - zeta * w / damped * s)

    def advance_many(self, cycles: int, mean_acceleration_rad_s2: float) -> None:
        """Advance by many cycles at once, with constant acceleration of the joint."""
        qq, qv, vq, vv = self._transition(cycles * self._cycle_s)
        rest = self._load * mean_acceleration_rad_s2 * self._static
        q, v = self.deflection_m - rest, self.rate_m_s
        self.deflection_m, self.rate_m_s = qq * q + qv * v + rest, vq * q + vv * v

    def advance(self, mean_acceleration_rad_s2: float) -> None:
        """Advance by one cycle with this mean acceleration of the joint."""
        rest = self._load * mean_acceleration_rad_s2 * self._static  # static deflection under a constant load
        q, v = self.deflection_m - rest, self.rate_m_s
        self.deflection_m = self._qq * q + self._qv * v + rest
        self.rate_m_s = self._vq * q + self._vv * v
