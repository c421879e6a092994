"""The last few seconds of a signal with one value per cycle: interpolated at an instant, or as a range of lags."""

from math import floor

import numpy as np
from numpy.typing import NDArray


class CycleHistory:
    """A ring of the last `length` cycles of one signal, stored twice so that any range of it is contiguous.

    Cycles are written in order. Cycles that the loop skipped get the value of the next written cycle.
    """

    def __init__(self, length: int, initial: float = 0.0) -> None:
        """Store `length` cycles, all `initial` before the first write."""
        self._length = length
        self._twice = np.full(2 * length, initial, dtype=np.float64)
        self._cycle: int | None = None

    def clear(self) -> None:
        """Reset to the state before the first write, with zeros."""
        self._twice[:] = 0.0
        self._cycle = None

    def write(self, cycle: int, value: float) -> None:
        """Store the value of a cycle that is later than the last written one."""
        if self._cycle == cycle - 1:  # nearly always
            place = cycle % self._length
            self._twice[place] = self._twice[place + self._length] = value
            self._cycle = cycle
            return
        first = cycle if self._cycle is None else self._cycle + 1
        self._fill(max(first, cycle - self._length + 1), cycle, value)
        self._cycle = cycle

    def fill(self, cycle: int, value: float) -> None:
        """Store one value for all cycles after the last written one, up to `cycle`, if there are any."""
        if self._cycle is not None and cycle > self._cycle:
            self._fill(max(self._cycle + 1, cycle - self._length + 1), cycle, value)
            self._cycle = cycle

    def _fill(self, first: int, last: int, value: float) -> None:
        """Fill at most `length` cycles, in constant time."""
        twice, length = self._twice, self._length
        start, count = first % length, last - first + 1
        if count <= 0:
            return
        twice[start : start + count] = value  # in either copy, or across both
        over = start + count - length
        if over > 0:
            twice[:over] = value
            twice[start + length :] = value
        else:
            twice[start + length : start + length + count] = value

    def at(self, cycle: float) -> float:
        """The value at a fractional cycle, by linear interpolation; outside the range, the nearest stored value."""
        if self._cycle is None:
            return float(self._twice[0])
        oldest, newest = self._cycle - self._length + 1, self._cycle
        cycle = min(max(cycle, float(oldest)), float(newest))
        low = floor(cycle)
        fraction = cycle - low
        value = float(self._twice[low % self._length])
        if fraction == 0.0:
            return value
        return value + fraction * (float(self._twice[(low + 1) % self._length]) - value)

    def lags(self, first: int, last: int) -> NDArray[np.float64]:
        """The values of cycles (newest - last) .. (newest - first), oldest first; shape (last - first + 1,). A view."""
        if self._cycle is None:
            return self._twice[: last - first + 1]
        end = (self._cycle - first) % self._length + self._length
        return self._twice[end - (last - first) : end + 1]
