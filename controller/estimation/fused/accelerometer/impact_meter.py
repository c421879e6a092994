"""An impact at the tip, measured by the accelerometer while it lasts.

Implements Eqs. 15, 16 of docs/fused.md.

The sensor shows q'' = - w^2 q - 2 zeta w q' + f: the excess of the samples by an impact's force f, summed over its few
milliseconds, is the velocity that the tip gains. The centre of that sum is the impact's instant. Two cumulative sums,
one for each sign, find its start and end (E. S. Page, Continuous inspection schemes, Biometrika 41, 1954).
"""

from collections import deque
from math import hypot, sqrt
from typing import NamedTuple

from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions


class ForceStep(NamedTuple):
    """A force that began, changed or ended at once, and then stayed. cycle: when; size_m: of its static deflection."""

    cycle: int
    size_m: float


class MeasuredImpact(NamedTuple):
    """What an impact added. cycle: its instant, in cycles; sum_m: of the samples' excess, as deflection; sum_std_m.

    cycle_std: of the instant, in cycles.
    """

    cycle: float
    cycle_std: float
    sum_m: float
    sum_std_m: float


class ImpactMeter:
    """Watches the samples' departures from what is expected, one a cycle.

    open: an impact is under way, or the sensor is not yet quiet after one.
    """

    def __init__(self, w: float, cycle_s: float, assumed: Assumptions = ASSUMPTIONS) -> None:
        """w: angular frequency of the mode, rad/s."""
        self._assumed = assumed.impact_meter
        self._longest = max(4, round(self._assumed.longest_rad / (w * cycle_s)))
        self._recent: deque[tuple[int, float]] = deque(
            maxlen=2 * self._longest + 5 * self._assumed.quiet_cycles
        )
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
        """Process a sample's departure; returns the impact once the sensor is quiet again after it, or the step of a
        force that goes on for too long to be an impact."""
        share = excess_m / std_m
        self._recent.append((cycle, excess_m))
        if not self.open:
            self._watch(cycle, share)
            return None
        if share * self._sign > self._assumed.over_stds:
            self._last_over = cycle
        if cycle - self._last_over < self._assumed.quiet_cycles:
            if cycle - self.since <= self._longest:
                return None
            step = self._step(std_m)
            self.reset()
            return step
        impact = self._measured(std_m)
        self.reset()
        return impact

    def _watch(self, cycle: int, share: float) -> None:
        assumed = self._assumed
        most = assumed.most_of_one_stds
        bounded = most if share > most else -most if share < -most else share
        up, down = self._up + (bounded - assumed.drift_stds), self._down - (bounded + assumed.drift_stds)
        if up <= 0.0:
            up, self._up_since = 0.0, cycle + 1
        if down <= 0.0:
            down, self._down_since = 0.0, cycle + 1
        self._up, self._down = up, down
        if up > assumed.alarm_stds or down > assumed.alarm_stds:
            rising = up > assumed.alarm_stds
            self._sign, self.since = (1.0, self._up_since) if rising else (-1.0, self._down_since)
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
        if not before or abs(mean) < self._assumed.step_stds * std_m or mean * self._sign < 0.0:
            return None
        half = max(1, len(before) // 2)  # by halves: a higher mode has another sign in each
        if max(
            abs(sum(part)) / len(part) for part in (before[:half], before[-half:])
        ) > self._assumed.quiet_share * abs(mean):
            return None
        if min(early / mean, late / mean) < self._assumed.steady_share:
            return None
        return ForceStep(first, -mean)

    def _measured(self, std_m: float) -> MeasuredImpact | None:
        first, last = self.since - 1, self._last_over + 1
        before = [m for cycle, m in self._recent if first - self._assumed.quiet_cycles <= cycle < first]
        inside = [one for one in self._recent if first <= one[0] <= last]
        after = [m for cycle, m in self._recent if cycle > last]
        if len(before) + len(inside) + len(after) != last - first + 2 * self._assumed.quiet_cycles:
            return None  # samples are missing
        total = sum([one[1] for one in inside])
        mean = total * self._sign / len(inside)
        around = max(abs(sum(before)) / len(before), abs(sum(after)) / len(after))
        if mean < self._assumed.mean_stds * std_m or around > max(
            self._assumed.quiet_share * mean,
            self._assumed.quiet_stds * std_m / sqrt(self._assumed.quiet_cycles),
        ):
            return None  # it swings on: a higher mode, a force that stays, a sensor that lies
        centre = sum([cycle * m for cycle, m in inside]) / total
        peak = max([m * self._sign for _, m in inside])
        spread = sum([(cycle - centre) ** 2 for cycle, _ in inside])
        return MeasuredImpact(
            centre,
            hypot(self._assumed.instant_cycles, std_m * sqrt(spread) / total),
            total,
            hypot(std_m * sqrt(len(inside)), self._assumed.edge_cycles * peak),
        )
