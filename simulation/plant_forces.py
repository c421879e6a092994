"""The causes that push on the first mode, each as a force term: cubic stiffness, quadratic damping, a foreign force."""

from math import pi, sin

from common.effects import effect_of, effects_of
from common.model import Model
from common.user_error import UserError
from simulation.plant_effects import ForceTerm


class CubicStiffness:
    """q_1'' -= w_1^2 c q_1^3, with w_1 as it is at the time."""

    def __init__(self, coefficient_per_m2: float) -> None:
        """c, positive for an arm that stiffens."""
        self._coefficient = coefficient_per_m2

    def acceleration_m_s2(
        self, angular_frequency: float, deflection_m: float, rate_m_s: float, time_s: float, duration_s: float
    ) -> float:
        """See ForceTerm. Raises UserError where a softening spring is bent beyond the point of no return."""
        relative = self._coefficient * deflection_m * deflection_m
        if not relative > -1.0:
            raise UserError(
                f"effects: cubic_stiffness: coefficient_per_m2 = {self._coefficient:g}: bent by {deflection_m:.4g} m, "
                f"the softening arm no longer returns at {time_s:.3f} s; take a smaller one, or excite the arm less"
            )
        return -angular_frequency * angular_frequency * relative * deflection_m


class QuadraticDamping:
    """q_1'' -= c q_1' |q_1'|; alone, v' = - c v |v| has the solution v / (1 + c |v| t), of which this is the mean."""

    def __init__(self, coefficient_per_m: float) -> None:
        """c >= 0."""
        self._coefficient = coefficient_per_m

    def acceleration_m_s2(
        self, angular_frequency: float, deflection_m: float, rate_m_s: float, time_s: float, duration_s: float
    ) -> float:
        """See ForceTerm."""
        pace = self._coefficient * abs(rate_m_s)
        return -pace * rate_m_s / (1.0 + pace * duration_s)


class PeriodicDisturbance:
    """q_1'' += A sin(2 pi f t + phase), as its mean over the duration."""

    def __init__(self, frequency_hz: float, amplitude_m_s2: float, phase_rad: float) -> None:
        """A, f and the phase at the recording's start."""
        self._w = 2.0 * pi * frequency_hz
        self._amplitude = amplitude_m_s2
        self._phase = phase_rad

    def acceleration_m_s2(
        self, angular_frequency: float, deflection_m: float, rate_m_s: float, time_s: float, duration_s: float
    ) -> float:
        """See ForceTerm."""
        half = 0.5 * self._w * duration_s
        middle = self._amplitude * sin(self._w * time_s + half + self._phase)
        return middle * (sin(half) / half if half else 1.0)


def force_terms(model: Model) -> list[ForceTerm]:
    """The force terms that a model's effects name."""
    terms: list[ForceTerm] = []
    if cubic := effect_of(model, "cubic_stiffness"):
        terms.append(CubicStiffness(cubic["coefficient_per_m2"]))
    if quadratic := effect_of(model, "quadratic_damping"):
        terms.append(QuadraticDamping(quadratic["coefficient_per_m"]))
    for periodic in effects_of(model, "periodic_disturbance"):
        terms.append(
            PeriodicDisturbance(periodic["frequency_hz"], periodic["amplitude_m_s2"], periodic["phase_rad"])
        )
    return terms
