"""Coulomb damping of a mode, exactly: between two reversals a constant force, at rest a force that holds."""

from collections.abc import Callable
from math import copysign, exp

from simulation.plant_drive import Stretch, first_instant
from simulation.plant_modes import ModalOscillator

_MOST_PIECES = (
    8  # of a stretch, which is shorter than half a period: more would be rounding errors chasing each other
)


class DryFriction:
    """q'' = (the linear equation) - F sign(q'); where q' = 0 it holds as long as what pulls is at most F."""

    def __init__(self, force_m_s2: float) -> None:
        """F >= 0, per modal mass."""
        self._force = force_m_s2

    def advance(self, mode: ModalOscillator, stretch: Stretch, force_m_s2: float) -> None:
        """Move the mode through a stretch of the joint's motion under a constant force, as ModalOscillator.advance."""
        rest = stretch._replace(jump_rad_s=0.0)
        for _ in range(_MOST_PIECES):
            used = self._piece(mode, rest, force_m_s2)
            if used >= rest.duration_s:
                break
            rest = _after(rest, used)
        mode.jolt(stretch.jump_rad_s)

    def acceleration_m_s2(self, rate_m_s: float, pull_m_s2: float) -> float:
        """What friction adds to q'' at a rate, where everything else adds up to `pull_m_s2`."""
        if rate_m_s != 0.0:
            return -copysign(self._force, rate_m_s)
        return -min(max(pull_m_s2, -self._force), self._force)

    def _piece(self, mode: ModalOscillator, stretch: Stretch, force_m_s2: float) -> float:
        """Move on to the next change of direction or of grip, at most through the stretch; returns the time used."""

        def pull(time_s: float) -> float:
            return mode.acceleration_m_s2(_joint_acceleration(stretch, time_s), force_m_s2)

        if mode.rate_m_s == 0.0 and abs(pull(0.0)) <= self._force:
            if abs(pull(stretch.duration_s)) <= self._force:  # theta'' decays one way, and so does the pull
                return stretch.duration_s
            return _first(lambda t: abs(pull(t)) > self._force, stretch)
        direction = copysign(1.0, mode.rate_m_s if mode.rate_m_s != 0.0 else pull(0.0))
        deflection, rate = mode.deflection_m, mode.rate_m_s

        def move(time_s: float) -> float:
            """To an instant of the stretch, from its start; the rate there, positive while the direction holds."""
            mode.deflection_m, mode.rate_m_s = deflection, rate
            mode.advance(_until(stretch, time_s), force_m_s2 - direction * self._force)
            return direction * mode.rate_m_s

        mode.advance(stretch, force_m_s2 - direction * self._force)
        if direction * mode.rate_m_s >= 0.0:
            return stretch.duration_s
        reversal_s = _first(lambda t: move(t) < 0.0, stretch)
        move(reversal_s)
        mode.rate_m_s = 0.0
        return reversal_s


def _first(holds: Callable[[float], bool], stretch: Stretch) -> float:
    return first_instant(holds, 0.0, stretch.duration_s)


def _joint_acceleration(stretch: Stretch, time_s: float) -> float:
    return stretch.start_rad_s2 * exp(-stretch.decay_per_s * time_s)


def _until(stretch: Stretch, time_s: float) -> Stretch:
    return stretch._replace(duration_s=time_s, end_rad_s2=_joint_acceleration(stretch, time_s))


def _after(stretch: Stretch, time_s: float) -> Stretch:
    begin = _joint_acceleration(stretch, time_s)
    return stretch._replace(duration_s=stretch.duration_s - time_s, start_rad_s2=begin)
