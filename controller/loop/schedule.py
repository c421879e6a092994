"""The absolute schedule of the cycles: the due time of the next one, and its number after an overrun."""

import time


class CycleClock:
    """Wakes at origin + n * cycle. An overrun skips whole cycles, without a burst; the number follows real time."""

    def __init__(self, cycle_s: float, origin_s: float) -> None:
        """Cycle 0 begins at `origin_s` of the monotonic clock."""
        self.origin_s = origin_s
        self._cycle_s = cycle_s
        self.misses = 0

    def start(self) -> int:
        """Sleep until cycle 0. Returns the first cycle to run, which is later if the origin has passed."""
        due, _ = next_cycle(-1, time.monotonic() - self.origin_s, self._cycle_s)
        self._sleep_until(due)
        return due

    def wait(self, last: int) -> int:
        """Sleep until the cycle after `last`, or the next future one. Returns its number."""
        due, missed = next_cycle(last, time.monotonic() - self.origin_s, self._cycle_s)
        self.misses += missed
        self._sleep_until(due)
        return due

    def _sleep_until(self, cycle: int) -> None:
        while (left := self.origin_s + cycle * self._cycle_s - time.monotonic()) > 0.0:
            time.sleep(left)


def next_cycle(last: int, now_s: float, cycle_s: float) -> tuple[int, int]:
    """The cycle to run after `last`, `now_s` after the start of cycle 0, and the number of missed cycles.

    A cycle that is late by less than its length still runs; cycles that have passed completely are skipped.
    """
    due = max(last + 1, int(now_s / cycle_s))
    return due, due - last - 1
