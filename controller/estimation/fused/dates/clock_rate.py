"""A clock refuted by arrivals: they recede, or advance, steadily against it, further than a delay can wander.

Implements Eq. 26 of docs/fused.md.

A wandering delay comes back and moves in fits. If a clock's period is wrong, the arrivals move away from it at an even
rate, for ever. The quarters of a span tell them apart: each must show at least half of its even share.
"""

from collections import deque
from itertools import pairwise
from math import sqrt
from typing import NamedTuple

from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions


class Rate(NamedTuple):
    """Relative excess of the true period over the supposed one, with its standard deviation."""

    rate: float
    std: float


class ClockRate:
    """Watches arrival minus nominal instant of the frames by a clock."""

    def __init__(self, spread_s: float, cycle_s: float, assumed: Assumptions = ASSUMPTIONS) -> None:
        """spread_s: of the capture delay; cycle_s: in which arrivals are read."""
        self._assumed = assumed.arrivals
        self._spread_s = spread_s
        self._cycle_s = cycle_s
        self._past: deque[tuple[float, float]] = deque(maxlen=self._assumed.rate_spans[-1] + 1)
        self.restart()

    def restart(self) -> None:
        """The count of frames, or the period supposed, has changed."""
        self._past.clear()
        self._count, self._instant, self._difference = 0, 0.0, 0.0

    def add(self, instant_s: float, difference_s: float) -> Rate | None:
        """A frame's nominal instant and its arrival less that, s; tells when the clock is refuted."""
        self._count += 1
        self._instant += instant_s / self._assumed.rate_group
        self._difference += difference_s / self._assumed.rate_group
        if self._count < self._assumed.rate_group:
            return None
        self._past.append((self._instant, self._difference))
        self._count, self._instant, self._difference = 0, 0.0, 0.0
        for span in self._assumed.rate_spans:
            if len(self._past) > span and (found := self._over(span)) is not None:
                return found
        return None

    def _over(self, span: int) -> Rate | None:
        past = self._past
        marks = [past[index - 1] for index in range(-span, 1, span // 4)]
        length_s, total = marks[-1][0] - marks[0][0], marks[-1][1] - marks[0][1]
        if (
            abs(total) < self._assumed.rate_beyond * self._spread_s
            or abs(total) > self._assumed.rate_most * length_s
        ):
            return None
        steps = [after[1] - before[1] for before, after in pairwise(marks)]
        even = total / len(steps)
        if min(step / even for step in steps) < self._assumed.rate_even:
            return None
        scatter = sum((step - even) ** 2 for step in steps) / (len(steps) - 1)
        wandered = max(len(steps) * scatter, self._spread_s**2) + self._cycle_s**2
        return Rate(total / length_s, sqrt(wandered) / length_s)
