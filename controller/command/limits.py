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
        self._cycle_s = cycle_s
        self._lag_s = drive.dead_time_s + 1.0 / (2.0 * pi * drive.bandwidth_hz) + cycle_s
        self._last = 0.0

    def restart(self) -> None:
        """The drive has stopped by itself: restart the command at zero."""
        self._last = 0.0

    def bound(self, wanted_rad_s: float, joint_position_rad: float) -> float:
        """The command nearest to the wanted one within all limits; a command that is not finite counts as zero.

        Near a position limit the velocity is at most what half the acceleration limit can stop in time, from the
        position of the joint when this command takes effect. If the position is unknown, the command is zero.
        """
        drive = self._drive
        wanted = wanted_rad_s if isfinite(wanted_rad_s) and isfinite(joint_position_rad) else 0.0
        wanted = min(max(wanted, -drive.max_velocity_rad_s), drive.max_velocity_rad_s)
        arriving = joint_position_rad + self._last * self._lag_s if isfinite(joint_position_rad) else 0.0
        up = self._approach(drive.max_position_rad - arriving)
        down = self._approach(arriving - drive.min_position_rad)
        step = drive.max_acceleration_rad_s2 * self._cycle_s
        bounded = min(max(wanted, self._last - step), self._last + step)
        bounded = min(max(bounded, -down), up)
        self._last = bounded
        return bounded

    def _approach(self, left_rad: float) -> float:
        """The largest velocity towards a position limit that is `left_rad` away."""
        left = max(0.0, left_rad)
        braking = _BRAKING_SHARE * self._drive.max_acceleration_rad_s2
        return min(sqrt(2.0 * braking * left), left / (_APPROACH_LAGS * self._lag_s))
