"""One number per cycle, the last few seconds of it: looked up at an instant between cycles, or as a run of lags."""

from math import floor

import numpy as np
from numpy.typing import NDArray


class CycleHistory:
    """A ring of the last `length` cycles of one signal, kept twice over so that any run of it is contiguous.

    Cycles are written in order; those that the loop skipped take the value of the cycle written next.
    """

    def __init__(self, length: int, initial: float = 0.0) -> None:
        """Hold `length` cycles, all `initial` before the first write."""
        self._length = length
        self._twice = np.full(2 * length, initial, dtype=np.float64)
        self._cycle: int | None = None

    def clear(self) -> None:
        """As before the first write, with zeros."""
        self._twice[:] = 0.0
        self._cycle = None

    def write(self, cycle: int, value: float) -> None:
        """Store the value of a cycle, which lies after the one written last."""
        if self._cycle == cycle - 1:  # nearly always
            place = cycle % self._length
            self._twice[place] = self._twice[place + self._length] = value
            self._cycle = cycle
            return
        first = cycle if self._cycle is None else self._cycle + 1
        self._fill(max(first, cycle - self._length + 1), cycle, value)
        self._cycle = cycle

    def fill(self, cycle: int, value: float) -> None:
        """Store one value for all cycles after the one written last, up to `cycle`; none where there are none."""
        if self._cycle is not None and cycle > self._cycle:
            self._fill(max(self._cycle + 1, cycle - self._length + 1), cycle, value)
            self._cycle = cycle

    def _fill(self, first: int, last: int, value: float) -> None:
        """At most `length` cycles, in constant time however many they are."""
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
        """The value at a fractional cycle, linear in between; the nearest held one outside of what is held."""
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
