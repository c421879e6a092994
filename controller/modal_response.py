"""How a bending mode answers to the joint's acceleration, exactly, for an acceleration linear over the cycle."""

from math import cos, exp, sin, sqrt

from common.model import Mode


class ModalResponse:
    """q'' + 2 zeta w q' + w^2 q = - participation * length * theta'', from rest."""

    def __init__(self, mode: Mode, length_m: float, cycle_s: float) -> None:
        """The mode's transition over one cycle; the load is taken as its mean over the cycle."""
        w, zeta = mode.angular_frequency, mode.damping_ratio
        damped = w * sqrt(1.0 - zeta * zeta)
        decay, c, s = exp(-zeta * w * cycle_s), cos(damped * cycle_s), sin(damped * cycle_s)
        self._qq = decay * (c + zeta * w / damped * s)
        self._qv = decay * s / damped
        self._vq = -w * w * self._qv
        self._vv = decay * (c - zeta * w / damped * s)
        self._load = -mode.participation * length_m
        self._static = 1.0 / (w * w)
        self._previous = 0.0
        self.deflection_m = 0.0
        self.rate_m_s = 0.0

    def advance(self, joint_acceleration_rad_s2: float) -> None:
        """Move on by one cycle, at whose end the joint accelerates so."""
        mean = 0.5 * (self._previous + joint_acceleration_rad_s2)
        self._previous = joint_acceleration_rad_s2
        rest = self._load * mean * self._static  # deflection in balance with a constant load
        q, v = self.deflection_m - rest, self.rate_m_s
        self.deflection_m = self._qq * q + self._qv * v + rest
        self.rate_m_s = self._vq * q + self._vv * v
