"""Health: the missing parts in each cycle, as bits of stillarm.controller.safety.table.BIT_OF.

Pure arithmetic on the cycle's input, so that a replay gives the same result.
"""

from math import isfinite

from stillarm.controller.estimation.estimate import Estimate, Status
from stillarm.controller.safety.table import BIT_OF, Event

DRIVE_SILENT_S = 0.05
DRIVE_LOST_S = 1.0
ACCELEROMETER_DEAD_S = 0.05
NON_FINITE_S = 0.05
STALL_S = 0.05
AFTER_STALL_S = 0.5  # s: until images that waited in the socket, with wrong dates, have passed
# of the last second's cycles: missing from the first on, present again below the second
MISSED_SHARE, MISSED_SHARE_AGAIN = (0.25, 0.1)
_MISSED_OVER_S = 1.0


class Health:
    """Checks the sensors, the drive, the loop and the estimate."""

    def __init__(self, cycle_s: float, stale_after_s: float, sampled_s: float = float("-inf")) -> None:
        """stale_after_s: largest age of the last measured image. sampled_s: time of the accelerometer's last sample, if
        there was one.
        """
        self._cycle_s = cycle_s
        self._stale_after_s = stale_after_s
        self._image_s = float("-inf")
        self._sample_s = sampled_s
        self._finite_s: float | None = None
        self._calm_from_s = float("-inf")
        self._missed = 0.0
        self._late = False

    def see_image(self, time_s: float) -> None:
        """A visual sample with a measurement was read."""
        self._image_s = time_s

    @property
    def sampled(self) -> bool:
        """Whether the accelerometer has ever delivered a sample."""
        return isfinite(self._sample_s)

    def missing(
        self, time_s: float, elapsed: int, acceleration_m_s2: float, joint_age_s: float, estimate: Estimate
    ) -> int:
        """The missing grounds in a cycle, as bits. elapsed: cycles since the last one that ran.

        An accelerometer without any sample so far is absent, not dead; a drive whose age is NaN has no reports.
        """
        found = 0
        if joint_age_s > DRIVE_SILENT_S:
            found = _DRIVE_SILENT if joint_age_s <= DRIVE_LOST_S else _DRIVE_SILENT | _DRIVE_LOST
        if isfinite(acceleration_m_s2):
            self._sample_s = time_s
        elif time_s - self._sample_s > ACCELEROMETER_DEAD_S and isfinite(self._sample_s):
            found |= _ACCELEROMETER_DEAD
        if time_s - self._image_s > self._stale_after_s:
            found |= _VISION_STALE
        if _sane(estimate) or self._finite_s is None:
            self._finite_s = time_s
        elif time_s - self._finite_s > NON_FINITE_S:
            found |= _NON_FINITE
        if elapsed > 1 or self._missed > 1e-3:
            found |= self._loop(time_s, elapsed)
        if time_s < self._calm_from_s:
            found |= _LOOP_STALLED
        return found

    def _loop(self, time_s: float, elapsed: int) -> int:
        """The grounds of the loop. The fraction of missed cycles is averaged over about a second."""
        if (elapsed - 1) * self._cycle_s >= STALL_S:
            self._calm_from_s = time_s + AFTER_STALL_S
        gain = min(1.0, elapsed * self._cycle_s / _MISSED_OVER_S)
        self._missed += gain * ((elapsed - 1) / elapsed - self._missed)
        self._late = self._missed > (MISSED_SHARE_AGAIN if self._late else MISSED_SHARE)
        return _DEADLINES_MISSED if self._late else 0


def _sane(estimate: Estimate) -> bool:
    """Whether the estimate is finite wherever its status claims a value."""
    if estimate.status is _ESTIMATED or estimate.status is _HELD:
        return isfinite(estimate.deflection_m + estimate.deflection_rate_m_s)
    return True


_ESTIMATED, _HELD = Status.ESTIMATED, Status.HELD
_DRIVE_SILENT, _DRIVE_LOST = BIT_OF[Event.DRIVE_SILENT], BIT_OF[Event.DRIVE_LOST]
_ACCELEROMETER_DEAD, _VISION_STALE = BIT_OF[Event.ACCELEROMETER_DEAD], BIT_OF[Event.VISION_STALE]
_NON_FINITE, _LOOP_STALLED = BIT_OF[Event.NON_FINITE], BIT_OF[Event.LOOP_STALLED]
_DEADLINES_MISSED = BIT_OF[Event.DEADLINES_MISSED]
