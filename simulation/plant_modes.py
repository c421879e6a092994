"""One bending mode of the simulated arm, solved exactly over a stretch of the joint's motion."""

from math import cos, exp, sin, sqrt

from common.model import Mode
from simulation.plant_drive import Stretch


class ModalOscillator:
    """q'' + 2 zeta w q' + w^2 q = - participation length theta'' + force, from rest.

    Over a stretch theta'' = a exp(-decay t) and the force is constant, so the particular solution is
    g a exp(-decay t) + force / w^2 with g = - participation length / (decay^2 - 2 zeta w decay + w^2); what
    is left of the state after taking it off moves as the free oscillator does. Exact for any frequency and
    any duration; the denominator has no zero because zeta < 1.
    """

    def __init__(
        self, mode: Mode, length_m: float, drive_decay_per_s: float, durations_s: tuple[float, ...]
    ) -> None:
        """drive_decay_per_s: that of the drive's lag; durations_s: those worth remembering the transition
        of."""
        self.deflection_m = 0.0
        self.rate_m_s = 0.0
        self._damping_ratio = mode.damping_ratio
        self._coupling_m = mode.participation * length_m
        self._drive_decay_per_s = drive_decay_per_s
        self._durations_s = durations_s
        self.tune(mode.angular_frequency)

    def tune(self, angular_frequency: float) -> None:
        """Vibrate at another frequency from now on, rad/s; damping ratio, deflection and rate stay."""
        w, zeta, drive_decay = angular_frequency, self._damping_ratio, self._drive_decay_per_s
        self.angular_frequency = w
        self._damping = 2.0 * zeta * w
        self._stiffness = w * w
        self._decay = zeta * w
        self._damped_frequency = w * sqrt((1.0 - zeta) * (1.0 + zeta))
        self._static_gain = -self._coupling_m / self._stiffness
        self._lagged_gain = -self._coupling_m / (
            drive_decay * drive_decay - self._damping * drive_decay + self._stiffness
        )
        self._transitions = {duration: self._transition(duration) for duration in self._durations_s}

    def advance(self, stretch: Stretch, force_m_s2: float) -> None:
        """Move through a stretch of the joint's motion under a constant force per modal mass."""
        duration, decay, start, end, jump = stretch
        a, b, c, d = self._transitions.get(duration) or self._transition(duration)
        gain = self._lagged_gain if decay else self._static_gain
        pushed = force_m_s2 / self._stiffness
        follow_start, follow_end = gain * start, gain * end
        x = self.deflection_m - follow_start - pushed
        y = self.rate_m_s + decay * follow_start
        self.deflection_m = a * x + b * y + follow_end + pushed
        self.rate_m_s = c * x + d * y - decay * follow_end - self._coupling_m * jump

    def jolt(self, jump_rad_s: float) -> None:
        """Feel a jump of theta'."""
        self.rate_m_s -= self._coupling_m * jump_rad_s

    def acceleration_m_s2(self, joint_acceleration_rad_s2: float, force_m_s2: float) -> float:
        """q'' at the present state."""
        return (
            force_m_s2
            - self._coupling_m * joint_acceleration_rad_s2
            - self._damping * self.rate_m_s
            - self._stiffness * self.deflection_m
        )

    def _transition(self, duration_s: float) -> tuple[float, float, float, float]:
        """The free oscillator's transition matrix [[a, b], [c, d]] of (deflection, rate) over a duration."""
        damped = self._damped_frequency
        shrink = exp(-self._decay * duration_s)
        cosine = shrink * cos(damped * duration_s)
        sine = shrink * sin(damped * duration_s) / damped
        return cosine + self._decay * sine, sine, -self._stiffness * sine, cosine - self._decay * sine
