"""A strike at the tip, measured by the accelerometer while it lasts.

The sensor shows q'' = - w^2 q - 2 zeta w q' + f: what a strike's force f adds to the expected samples, summed over its
few milliseconds, is the velocity it gives the tip, and the centre of that sum is its instant. Its start and end are
found by two cumulative sums, one for each sign (E. S. Page, Continuous inspection schemes, Biometrika 41, 1954).
"""

from collections import deque
from math import hypot, sqrt
from typing import NamedTuple

_DRIFT, _ALARM = 1.0, 12.0  # standard deviations: by chance once in a thousand hours
_MOST_OF_ONE = 6.0  # standard deviations: one or two wild samples are no strike
_OVER = 2.0  # standard deviations: the strike is still under way
_QUIET = 6  # cycles before and after it
_LONGEST_RAD = 0.35  # of the mode's phase: a longer force is no strike
_QUIET_STDS = 3.0
_MEAN_STDS, _QUIET_SHARE = 3.0, 0.25  # a strike's mean; that around it as a share of it
_EDGE = 0.4  # cycles: of the sum of a pulse that starts and ends between samples
_INSTANT = 0.29  # cycles, likewise
_STEP_STDS = 4.0  # of one sample: a smaller step is left to the images
_STEADY_SHARE = 0.6  # of a step's mean, by its first and last third: over 0.35 rad a cosine falls to 0.94


class ForceStep(NamedTuple):
    """A force that began, changed or ended at once, and then stayed. cycle: when; size_m: of its static deflection."""

    cycle: int
    size_m: float


class MeasuredImpact(NamedTuple):
    """What a strike added. cycle: its instant, in cycles; sum_m: of the samples' excess, as deflection; sum_std_m.

    cycle_std: of the instant, in cycles.
    """

    cycle: float
    cycle_std: float
    sum_m: float
    sum_std_m: float


class ImpactMeter:
    """Watches the samples' departures from what is expected, one a cycle.

    open: a strike is under way, or the sensor is not yet quiet after one.
    """

    def __init__(self, w: float, cycle_s: float) -> None:
        """w: angular frequency of the mode, rad/s."""
        self._longest = max(4, round(_LONGEST_RAD / (w * cycle_s)))
        self._recent: deque[tuple[int, float]] = deque(maxlen=2 * self._longest + 5 * _QUIET)
        self.reset()

    def reset(self) -> None:
        """Nothing seen; what is under way is given up."""
        self._up = self._down = 0.0
        self._up_since = self._down_since = 0
        self._last_over = 0
        self._sign = 0.0
        self.open = False
        self.since = 0

    def see(self, cycle: int, excess_m: float, std_m: float) -> MeasuredImpact | ForceStep | None:
        """Take in a sample's departure; returns the strike once the sensor is quiet again after it, or the step of a
        force that goes on for too long to be a strike."""
        share = excess_m / std_m
        self._recent.append((cycle, excess_m))
        if not self.open:
            self._watch(cycle, share)
            return None
        if share * self._sign > _OVER:
            self._last_over = cycle
        if cycle - self._last_over < _QUIET:
            if cycle - self.since <= self._longest:
                return None
            step = self._step(std_m)
            self.reset()
            return step
        impact = self._measured(std_m)
        self.reset()
        return impact

    def _watch(self, cycle: int, share: float) -> None:
        bounded = min(max(share, -_MOST_OF_ONE), _MOST_OF_ONE)
        self._up += bounded - _DRIFT
        self._down -= bounded + _DRIFT
        if self._up <= 0.0:
            self._up, self._up_since = 0.0, cycle + 1
        if self._down <= 0.0:
            self._down, self._down_since = 0.0, cycle + 1
        if self._up > _ALARM or self._down > _ALARM:
            self._sign, self.since = (1.0, self._up_since) if self._up > _ALARM else (-1.0, self._down_since)
            self._last_over, self.open = cycle, True

    def _step(self, std_m: float) -> ForceStep | None:
        """The force's step if the sensor has been still before it, and has shown the same ever since.

        A step f makes the deflection begin at -f of the vibration about the new place of rest, which is what the
        accelerometer shows.
        """
        first = self.since
        before = [m for cycle, m in self._recent if first - self._longest <= cycle < first - 1]
        inside = [m for cycle, m in self._recent if cycle > first]
        third = max(1, len(inside) // 3)
        mean, early, late = (sum(part) / len(part) for part in (inside, inside[:third], inside[-third:]))
        if not before or abs(mean) < _STEP_STDS * std_m or mean * self._sign < 0.0:
            return None
        half = max(1, len(before) // 2)  # by halves: a higher mode has another sign in each
        if max(abs(sum(part)) / len(part) for part in (before[:half], before[-half:])) > _QUIET_SHARE * abs(
            mean
        ):
            return None
        if min(early / mean, late / mean) < _STEADY_SHARE:
            return None
        return ForceStep(first, -mean)

    def _measured(self, std_m: float) -> MeasuredImpact | None:
        first, last = self.since - 1, self._last_over + 1
        before = [m for cycle, m in self._recent if first - _QUIET <= cycle < first]
        inside = [one for one in self._recent if first <= one[0] <= last]
        after = [m for cycle, m in self._recent if cycle > last]
        if len(before) + len(inside) + len(after) != last - first + 2 * _QUIET:
            return None  # samples are missing
        total = sum([one[1] for one in inside])
        mean = total * self._sign / len(inside)
        around = max(abs(sum(before)) / len(before), abs(sum(after)) / len(after))
        if mean < _MEAN_STDS * std_m or around > max(_QUIET_SHARE * mean, _QUIET_STDS * std_m / sqrt(_QUIET)):
            return None  # it swings on: a higher mode, a force that stays, a sensor that lies
        centre = sum([cycle * m for cycle, m in inside]) / total
        peak = max([m * self._sign for _, m in inside])
        spread = sum([(cycle - centre) ** 2 for cycle, _ in inside])
        return MeasuredImpact(
            centre,
            hypot(_INSTANT, std_m * sqrt(spread) / total),
            total,
            hypot(std_m * sqrt(len(inside)), _EDGE * peak),
        )
