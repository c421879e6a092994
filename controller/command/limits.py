"""Position, velocity and acceleration limits of the joint, which apply to every command."""

from math import isfinite, pi, sqrt

from stillarm.common.files.model import Drive

_BRAKING_SHARE = 0.5  # of the acceleration limit, assumed for stopping before a position limit
_APPROACH_LAGS = 4.0  # time constant of the exponential approach to a limit, in lags of the drive


class CommandLimits:
    """Bounds a joint velocity command so that the joint stays within the model's limits (model file, [drive])."""

    def __init__(self, drive: Drive, cycle_s: float) -> None:
        """Start from a command of zero."""
        self._drive = drive
        self._lag_s = drive.dead_time_s + 1.0 / (2.0 * pi * drive.bandwidth_hz) + cycle_s
        self._step = drive.max_acceleration_rad_s2 * cycle_s
        self._braking = 2.0 * (_BRAKING_SHARE * drive.max_acceleration_rad_s2)
        self._approach_s = _APPROACH_LAGS * self._lag_s
        self._last = 0.0

    def restart(self) -> None:
        """The drive has stopped by itself: restart the command at zero."""
        self._last = 0.0

    def bound(self, wanted_rad_s: float, joint_position_rad: float) -> float:
        """The command nearest to the wanted one within all limits; a command that is not finite counts as zero.

        Near a position limit the velocity is at most what half the acceleration limit can stop in time, from the
        position of the joint when this command takes effect. If the position is unknown, the command is zero.
        """
        drive, last, top = self._drive, self._last, self._drive.max_velocity_rad_s
        placed = isfinite(joint_position_rad)
        wanted = wanted_rad_s if placed and isfinite(wanted_rad_s) else 0.0
        wanted = top if wanted > top else -top if wanted < -top else wanted
        arriving = joint_position_rad + last * self._lag_s if placed else 0.0
        up = self._approach(drive.max_position_rad - arriving)
        down = self._approach(arriving - drive.min_position_rad)
        bounded = _between(last - self._step, wanted, last + self._step)
        self._last = bounded = _between(-down, bounded, up)
        return bounded

    def _approach(self, left_rad: float) -> float:
        """The largest velocity towards a position limit that is `left_rad` away."""
        if not left_rad > 0.0:
            return 0.0
        braking, approaching = sqrt(self._braking * left_rad), left_rad / self._approach_s
        return approaching if approaching < braking else braking


def _between(lowest: float, value: float, highest: float) -> float:
    """The value within both limits; the upper one counts where they cross."""
    raised = lowest if lowest > value else value
    return highest if highest < raised else raised
