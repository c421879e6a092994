"""The simulated drive: a joint velocity that follows its command late, with a lag and within limits.

    theta'' = clip(decay (command - theta'), max_acceleration),   decay = 2 pi bandwidth

between the end stops; a joint that runs into one stops there at once. While the command is constant the
motion is a stretch of constant theta'' followed by one of exponentially decaying theta'', so it is solved
exactly, piece by piece.
"""

from collections import deque
from collections.abc import Callable, Sequence
from math import copysign, expm1, floor, isnan, log, pi
from typing import NamedTuple

from common.model import Drive
from simulation.plant_effects import CommandRule

_BISECTIONS = 60  # to the last bit of a duration within a step


class Stretch(NamedTuple):
    """A stretch of time in which theta'' = start exp(-decay t), and the velocity's jump at its end (an
    impact).

    Units: s, 1/s, rad/s^2, rad/s^2, rad/s. A decay of 0 is a constant theta''.
    """

    duration_s: float
    decay_per_s: float
    start_rad_s2: float
    end_rad_s2: float
    jump_rad_s: float


class JointDrive:
    """Position, velocity and acceleration of the joint; starts at rest at zero, or at the end stop nearest
    to it."""

    def __init__(self, drive: Drive, cycle_s: float, rules: Sequence[CommandRule] = ()) -> None:
        """cycle_s: how long each command is held. rules: applied in turn to the command after dead time and
        limit."""
        self.decay_per_s = 2.0 * pi * drive.bandwidth_hz
        self._max_velocity = drive.max_velocity_rad_s
        self._max_acceleration = drive.max_acceleration_rad_s2
        self._linear_error = drive.max_acceleration_rad_s2 / self.decay_per_s
        self._lowest, self._highest = drive.min_position_rad, drive.max_position_rad
        self._rules = tuple(rules)
        cycles = drive.dead_time_s / cycle_s
        whole = floor(cycles + 1e-9)
        fraction = cycles - whole
        self._late_s = fraction * cycle_s if fraction > 1e-9 else 0.0
        self._rest_s = cycle_s - self._late_s
        self._pending: deque[float] = deque([0.0] * whole)
        self._acting = 0.0
        self.position_rad = min(max(0.0, self._lowest), self._highest)
        self.velocity_rad_s = 0.0
        self.acceleration_rad_s2 = 0.0

    @property
    def usual_durations_s(self) -> tuple[float, ...]:
        """How long the stretches last when no limit is met."""
        return (self._late_s, self._rest_s) if self._late_s else (self._rest_s,)

    def advance(self, command_rad_s: float) -> list[Stretch]:
        """Move through one cycle; `command_rad_s` is issued at its beginning. Returns the cycle's stretches
        in order.

        Raises ValueError for a command that is not a number.
        """
        limit = self._max_velocity
        if not -limit <= command_rad_s <= limit:
            if isnan(command_rad_s):
                raise ValueError("the drive's command is not a number")
            command_rad_s = copysign(limit, command_rad_s)
        self._pending.append(command_rad_s)
        stretches: list[Stretch] = []
        if self._late_s:
            self._hold(self._late_s, self._acting, stretches)
        target = self._pending.popleft()
        for rule in self._rules:
            target = rule(target)
        self._acting = target
        self._hold(self._rest_s, target, stretches)
        last = stretches[-1]
        self.acceleration_rad_s2 = 0.0 if last.jump_rad_s else last.end_rad_s2
        return stretches

    def _hold(self, duration_s: float, target: float, stretches: list[Stretch]) -> None:
        """Move for `duration_s` towards the constant velocity `target`."""
        while duration_s > 0.0:
            if self._pushes_on_stop(target):
                stretches.append(Stretch(duration_s, 0.0, 0.0, 0.0, 0.0))
                return
            error = target - self.velocity_rad_s
            excess = abs(error) - self._linear_error
            # what rounding leaves of an excess must not count as one, or the loop would never end
            if excess > 1e-12 * (self._linear_error + abs(target) + abs(self.velocity_rad_s)):
                used = self._accelerate(error, min(duration_s, excess / self._max_acceleration), stretches)
            else:
                used = self._approach(target, error, duration_s, stretches)
            duration_s -= used

    def _pushes_on_stop(self, target: float) -> bool:
        if self.velocity_rad_s != 0.0:
            return False
        position = self.position_rad
        return (position >= self._highest and target >= 0.0) or (position <= self._lowest and target <= 0.0)

    def _accelerate(self, error: float, duration_s: float, stretches: list[Stretch]) -> float:
        """At the acceleration limit; returns the time used."""
        velocity = self.velocity_rad_s
        acceleration = copysign(self._max_acceleration, error)

        def motion(t: float) -> tuple[float, float]:
            return t * (velocity + 0.5 * acceleration * t), velocity + acceleration * t

        turn = -velocity / acceleration
        duration_s, jump = self._move(motion, duration_s, turn)
        stretches.append(Stretch(duration_s, 0.0, acceleration, acceleration, jump))
        return duration_s

    def _approach(self, target: float, error: float, duration_s: float, stretches: list[Stretch]) -> float:
        """Within the first-order lag; returns the time used."""
        decay = self.decay_per_s
        velocity = self.velocity_rad_s

        def motion(t: float) -> tuple[float, float]:
            closed = -expm1(-decay * t)
            return target * t - error * closed / decay, velocity + error * closed

        # where the velocity passes through zero, if it ever does
        turn = log(error / target) / decay if target * error > 0.0 else 0.0
        duration_s, jump = self._move(motion, duration_s, turn)
        start = decay * error
        stretches.append(Stretch(duration_s, decay, start, start * (1.0 + expm1(-decay * duration_s)), jump))
        return duration_s

    def _move(
        self, motion: Callable[[float], tuple[float, float]], duration_s: float, turn_s: float
    ) -> tuple[float, float]:
        """Take over position and velocity after `motion`, or after its first impact on an end stop.

        motion: time -> (way, velocity), its velocity changing sign at `turn_s` only. Returns the time used
        and the velocity's jump at its end.
        """
        lowest, highest, start = self._lowest, self._highest, self.position_rad
        spans = ((0.0, turn_s), (turn_s, duration_s)) if 0.0 < turn_s < duration_s else ((0.0, duration_s),)
        for before, after in spans:
            way, velocity = motion(after)
            if lowest <= start + way <= highest:
                continue
            if start + way > highest:
                stop, impact_s = (
                    highest,
                    first_instant(lambda t: start + motion(t)[0] > highest, before, after),
                )
            else:
                stop, impact_s = lowest, first_instant(lambda t: start + motion(t)[0] < lowest, before, after)
            self.position_rad, self.velocity_rad_s = stop, 0.0
            return impact_s, -motion(impact_s)[1]
        self.position_rad = start + way
        self.velocity_rad_s = velocity
        return duration_s, 0.0


def first_instant(holds: Callable[[float], bool], before: float, after: float) -> float:
    """The instant from which `holds` is true; it is false at `before`, true at `after` and changes once."""
    for _ in range(_BISECTIONS):
        middle = 0.5 * (before + after)
        if holds(middle):
            after = middle
        else:
            before = middle
    return after
