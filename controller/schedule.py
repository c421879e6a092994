"""The absolute schedule of the cycles: when the next one is due, and which number it has after an overrun."""

import time


class CycleClock:
    """Wakes at origin + n * cycle. An overrun skips whole cycles and never bursts; the number follows real time."""

    def __init__(self, cycle_s: float, origin_s: float) -> None:
        """Cycle 0 begins at `origin_s` of the monotonic clock."""
        self.origin_s = origin_s
        self._cycle_s = cycle_s
        self.misses = 0

    def start(self) -> int:
        """Sleep until cycle 0; returns the first cycle to run, which is later when the origin has passed."""
        due, _ = next_cycle(-1, time.monotonic() - self.origin_s, self._cycle_s)
        self._sleep_until(due)
        return due

    def wait(self, last: int) -> int:
        """Sleep until the cycle after `last`, or until the next one that is still to come; returns its number."""
        due, missed = next_cycle(last, time.monotonic() - self.origin_s, self._cycle_s)
        self.misses += missed
        self._sleep_until(due)
        return due

    def _sleep_until(self, cycle: int) -> None:
        while (left := self.origin_s + cycle * self._cycle_s - time.monotonic()) > 0.0:
            time.sleep(left)


def next_cycle(last: int, now_s: float, cycle_s: float) -> tuple[int, int]:
    """The cycle to run after `last`, seen `now_s` after cycle 0 began, and how many were missed.

    A cycle whose start has passed by less than its length is still run, late; those wholly passed are skipped.
    """
    due = max(last + 1, int(now_s / cycle_s))
    return due, due - last - 1
