"""The joint model: velocity, position and acceleration that follow from the commands sent.

theta'' comes from here, never from differentiating an encoder: one count of noise in a rate, differentiated over a
millisecond, is metres per second squared at the tip.
"""

from collections import deque
from math import atan, exp, expm1, pi

from stillarm.common.files.model import Drive

STEPWISE_CYCLES = 300
"""Cycles of a pause that are stepped one by one; the rest is passed at once. 0.3 ms; 35 lags of the default drive."""


class DriveModel:
    """First-order velocity lag after a dead time, with the drive's limits (model file, section [drive])."""

    def __init__(self, drive: Drive, cycle_s: float, position_rad: float = 0.0) -> None:
        """Start at rest at a position, with zero commands in the dead time."""
        self._drive = drive
        self._cycle_s = cycle_s
        self._rate = 2.0 * pi * drive.bandwidth_hz
        self._stay = exp(-self._rate * cycle_s)
        whole = int(drive.dead_time_s / cycle_s)
        self._fraction = drive.dead_time_s / cycle_s - whole
        # commands in the dead time, newest first
        self._waiting = deque([0.0] * (whole + 2), maxlen=whole + 2)
        self.position_rad = position_rad
        self.velocity_rad_s = 0.0
        self.acceleration_rad_s2 = 0.0
        self.mean_acceleration_rad_s2 = 0.0

    def rest_at(self, position_rad: float) -> None:
        """Come to rest there, with zero commands in the dead time."""
        self._waiting.extend([0.0] * len(self._waiting))
        self.position_rad = position_rad
        self.velocity_rad_s = self.acceleration_rad_s2 = self.mean_acceleration_rad_s2 = 0.0

    def report(self, position_rad: float) -> None:
        """Set the encoder's reading, rad."""
        self.position_rad = position_rad

    def advance(self, command_rad_s: float) -> None:
        """Advance by one cycle during which `command_rad_s` is sent.

        acceleration_rad_s2 is then the value at the cycle's end; mean_acceleration_rad_s2 is the mean over the cycle.
        The mean is larger while the command ramps: theta'' jumps with each step of the command and decays until the
        next.
        """
        drive, waiting, cycle_s = self._drive, self._waiting, self._cycle_s
        top = drive.max_velocity_rad_s
        waiting.appendleft(-top if command_rad_s < -top else top if command_rad_s > top else command_rad_s)
        arriving = waiting[-2] + self._fraction * (waiting[-1] - waiting[-2])
        before, most = self.velocity_rad_s, drive.max_acceleration_rad_s2 * cycle_s
        change = (arriving - before) * (1.0 - self._stay)
        if not -most <= change <= most:
            change = most if change > 0.0 else -most
        self.velocity_rad_s = before + change
        self.mean_acceleration_rad_s2 = change / cycle_s
        self.position_rad += cycle_s * (before + 0.5 * change)
        if not drive.min_position_rad <= self.position_rad <= drive.max_position_rad:
            self._stop_at_the_end()
        limit = drive.max_acceleration_rad_s2
        acceleration = self._rate * (arriving - self.velocity_rad_s)
        self.acceleration_rad_s2 = (
            limit if acceleration > limit else -limit if acceleration < -limit else acceleration
        )

    def advance_many(self, cycles: int, command_rad_s: float) -> None:
        """Advance by many cycles at once, with `command_rad_s` arriving throughout: the rest of a pause that is longer
        than dead time and ramp, after `STEPWISE_CYCLES` single steps.

        mean_acceleration_rad_s2 is then the mean over all of them.
        """
        drive, cycle_s = self._drive, self._cycle_s
        arriving = min(max(command_rad_s, -drive.max_velocity_rad_s), drive.max_velocity_rad_s)
        self._waiting.extend([arriving] * len(self._waiting))
        angle = self._rate * cycle_s
        off, gone = self.velocity_rad_s - arriving, expm1(-cycles * angle)
        # the sum of the trapezoids of off * stay^k
        way = cycle_s * (cycles * arriving + off * 0.5 * (1.0 + self._stay) * gone / expm1(-angle))
        velocity = arriving + off * (1.0 + gone)
        self.mean_acceleration_rad_s2 = (velocity - self.velocity_rad_s) / (cycles * cycle_s)
        self.acceleration_rad_s2 = 0.0
        self.velocity_rad_s = velocity
        self.position_rad += way
        self._stop_at_the_end()

    def _stop_at_the_end(self) -> None:
        drive = self._drive
        stop = min(max(self.position_rad, drive.min_position_rad), drive.max_position_rad)
        if (self.position_rad - stop) * self.velocity_rad_s > 0.0:
            self.velocity_rad_s = 0.0
        self.position_rad = stop


def drive_lead_s(drive: Drive, angular_frequency: float) -> float:
    """Delay of the joint's velocity behind its command at a frequency: dead time plus the first-order lag's phase."""
    return drive.dead_time_s + atan(angular_frequency / (2.0 * pi * drive.bandwidth_hz)) / angular_frequency
