"""The level at which an accelerometer's signal is clipped, found from the samples themselves.

Implements Eq. 9 of docs/fused.md.

Clipping leaves an atom in the distribution: one extreme value again and again, and almost none just below it. Noise
alone puts fewer samples on its outermost level than on the one before.
"""

from math import inf

from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions


class _Side:
    """The upper side; level: where the signal is cut off, or infinity."""

    def __init__(self, assumed: Assumptions = ASSUMPTIONS) -> None:
        self._assumed = assumed.samples
        self.level = inf
        self._forget()

    def _forget(self) -> None:
        self._top = self._next = -inf
        self._hits = self._next_hits = self._age = 0

    def see(self, value: float) -> None:
        if value > self.level:  # it was no limit, or is none any more
            self.level = inf
        self._age += 1
        if self._age > self._assumed.clip_watched_cycles:
            self._forget()
        if value < self._next:
            return
        if value > self._top:
            self._next, self._next_hits = self._top, self._hits
            self._top, self._hits = value, 1
        elif value == self._top:
            self._hits += 1
            if (
                self._hits >= self._assumed.clip_hits
                and self._hits >= self._assumed.clip_times_next * self._next_hits
            ):
                self.level = value
        elif value > self._next:
            self._next, self._next_hits = value, 1
        else:
            self._next_hits += 1


class Clipping:
    """Both sides of a signal. low, high: where it is cut off, in its own unit: the range's ends where nothing is found.

    found: whether a limit within the configured range has been found.
    """

    def __init__(self, limit: float, assumed: Assumptions = ASSUMPTIONS) -> None:
        """limit: end of the range as it is configured."""
        self._limit = limit
        self._upper, self._lower = _Side(assumed), _Side(assumed)
        self._levels = (self._upper.level, self._lower.level)
        self._place()

    def _place(self) -> None:
        """What follows from both sides' levels."""
        upper, lower = self._levels
        self.high = min(self._limit, upper)
        self.low = max(-self._limit, -lower)
        self.found = upper < self._limit or lower < self._limit

    def see(self, value: float) -> None:
        """Process a sample that is not simply the last one held over."""
        upper, lower = self._upper, self._lower
        upper.see(value)
        lower.see(-value)
        if self._levels != (upper.level, lower.level):  # seldom
            self._levels = (upper.level, lower.level)
            self._place()

    def near(self, expected: float, margin: float) -> bool:
        """Whether a sample expected there is likely to be clipped. All such samples are left out: to use only the
        unclipped ones would bias the mean."""
        return not self.low + margin < expected < self.high - margin
