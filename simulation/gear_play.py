"""Backlash: play between motor and joint, as a change of the motor's stretches into the joint's."""

from math import copysign, expm1, log1p

from simulation.plant_drive import Stretch, first_instant


class GearPlay:
    """Play of total width `gap`: theta stands still while the motor crosses it, and moves with the motor otherwise.

    Where the motor meets the other flank theta' jumps to the motor's velocity, which is an impulse of theta''.
    """

    def __init__(self, gap_rad: float) -> None:
        """gap > 0. The motor begins in the middle of the play."""
        self._half_rad = 0.5 * gap_rad
        self.ahead_rad = 0.0
        """Motor position - theta, within half the gap to either side."""
        self.in_contact = False
        """Whether theta now moves with the motor."""

    def follow(self, velocity_rad_s: float, stretches: list[Stretch]) -> list[Stretch]:
        """The joint's stretches for the motor's; `velocity_rad_s` is the motor's at their beginning."""
        followed: list[Stretch] = []
        for stretch in stretches:
            motion = _Motion(velocity_rad_s, stretch)
            turn = motion.turn_s()
            for begin, end in ((0.0, turn), (turn, stretch.duration_s)):
                if end > begin:
                    followed += self._span(motion, begin, end)
            if stretch.jump_rad_s and self.in_contact:  # the motor's own end stop
                followed.append(_standing(0.0)._replace(jump_rad_s=stretch.jump_rad_s))
            velocity_rad_s = motion.velocity(stretch.duration_s) + stretch.jump_rad_s
        return followed

    def _span(self, motion: "_Motion", begin: float, end: float) -> list[Stretch]:
        """The joint's stretches over a span in which the motor does not turn."""
        way = motion.way(end) - motion.way(begin)
        if way == 0.0:
            self.in_contact = False
            return [_standing(end - begin)]
        flank = copysign(self._half_rad, way)
        if self.ahead_rad == flank:
            self.in_contact = True
            return [motion.part(begin, end)]
        self.in_contact = False
        ahead = self.ahead_rad + way
        # by the sum as it is rounded: what is on the flank later has struck it now
        if (flank - ahead) * way > 0.0:
            self.ahead_rad = ahead
            return [_standing(end - begin)]
        short = flank - self.ahead_rad + motion.way(begin)
        contact = first_instant(lambda time: (motion.way(time) - short) * way >= 0.0, begin, end)
        self.ahead_rad = flank
        self.in_contact = True
        struck = Stretch(contact - begin, 0.0, 0.0, 0.0, motion.velocity(contact))
        return [struck, motion.part(contact, end)] if end > contact else [struck]


class _Motion:
    """The motor's way and velocity within one stretch."""

    def __init__(self, velocity_rad_s: float, stretch: Stretch) -> None:
        self._velocity = velocity_rad_s
        self._stretch = stretch

    def velocity(self, time_s: float) -> float:
        return self._velocity + self._stretch.start_rad_s2 * self._risen(time_s)

    def way(self, time_s: float) -> float:
        decay, start = self._stretch.decay_per_s, self._stretch.start_rad_s2
        if decay == 0.0:
            return time_s * (self._velocity + 0.5 * start * time_s)
        return self._velocity * time_s + start / decay * (time_s - self._risen(time_s))

    def turn_s(self) -> float:
        """When the velocity passes through zero within the stretch; else its end."""
        duration, decay, start = (
            self._stretch.duration_s,
            self._stretch.decay_per_s,
            self._stretch.start_rad_s2,
        )
        if self._velocity * start >= 0.0:
            return duration
        if decay == 0.0:
            return min(duration, -self._velocity / start)
        share = self._velocity * decay / start  # negative
        return min(duration, -log1p(share) / decay) if share > -1.0 else duration

    def part(self, begin: float, end: float) -> Stretch:
        """The stretch from one instant of it to another, without its jump."""
        decay, start = self._stretch.decay_per_s, self._stretch.start_rad_s2
        first, last = (start * (1.0 + expm1(-decay * time)) for time in (begin, end))
        return Stretch(end - begin, decay, first, last, 0.0)

    def _risen(self, time_s: float) -> float:
        """Integral of exp(-decay t)."""
        decay = self._stretch.decay_per_s
        return time_s if decay == 0.0 else -expm1(-decay * time_s) / decay


def _standing(duration_s: float) -> Stretch:
    return Stretch(duration_s, 0.0, 0.0, 0.0, 0.0)
