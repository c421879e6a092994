"""The benchmark's own arm and joint: exact from cycle to cycle, for a command and a force held over it."""

from math import pi

import numpy as np
from numpy.typing import NDArray

from benchmarks.estimators.regimes import CYCLE_S, Arm

Values = NDArray[np.float64]


class Plant:
    """theta'' = b (u - theta'), q'' + 2 zeta w q' + w^2 q = - p L theta'' + f; u is the command, dead_cycles old.

    b = 2 pi bandwidth_hz. The state is (theta, theta', q, q'); its transition is the matrix exponential, by its series.
    """

    def __init__(
        self, arm: Arm, length_m: float, participation: float, bandwidth_hz: float, dead_cycles: int
    ) -> None:
        """At rest at zero."""
        w, lag = arm.angular_frequency, 2.0 * pi * bandwidth_hz
        decay, lever = 2.0 * arm.damping_ratio * w, participation * length_m
        rates = np.zeros((6, 6))
        rates[0, 1] = rates[2, 3] = 1.0
        rates[1, 1], rates[1, 4] = -lag, lag
        rates[3] = (0.0, lever * lag, -w * w, -decay, -lever * lag, 1.0)
        self._rows: list[list[float]] = _exponential(rates * CYCLE_S)[:4].tolist()
        self._tip: list[float] = (length_m * rates[1] + rates[3]).tolist()
        self._length = length_m
        self._w = w
        self._under_way = [0.0] * dead_cycles
        self.theta = self.theta_rate = self.deflection = self.rate = 0.0
        self._command = 0.0
        self.force_m_s2 = 0.0

    @property
    def tip_m(self) -> float:
        """Transverse position of the tip."""
        return self._length * self.theta + self.deflection

    @property
    def tip_rate_m_s(self) -> float:
        """Its rate."""
        return self._length * self.theta_rate + self.rate

    @property
    def tip_acceleration_m_s2(self) -> float:
        """Its acceleration under the command and the force that act now."""
        t = self._tip
        return (
            t[1] * self.theta_rate + t[2] * self.deflection + t[3] * self.rate + t[4] * self._command
            + t[5] * self.force_m_s2
        )  # fmt: skip

    @property
    def amplitude_m(self) -> float:
        """Momentary amplitude of the deflection."""
        return float(np.hypot(self.deflection, self.rate / self._w))

    def strike(self, velocity_m_s: float) -> None:
        """Add to the deflection's rate at once."""
        self.rate += velocity_m_s

    def advance(self, command_rad_s: float) -> None:
        """Move on by one cycle."""
        self._under_way.append(command_rad_s)
        self._command = u = self._under_way.pop(0)
        a, b, c, d, f = self.theta, self.theta_rate, self.deflection, self.rate, self.force_m_s2
        self.theta, self.theta_rate, self.deflection, self.rate = [
            r[0] * a + r[1] * b + r[2] * c + r[3] * d + r[4] * u + r[5] * f for r in self._rows
        ]


def _exponential(matrix: Values) -> Values:
    result = term = np.eye(len(matrix))
    for order in range(1, 20):
        term = term @ matrix / order
        result = result + term
    return result
