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
        first = cycle if self._cycle is None else max(self._cycle + 1, cycle - self._length + 1)
        for n in range(first, cycle + 1):
            place = n % self._length
            self._twice[place] = value
            self._twice[place + self._length] = value
        self._cycle = cycle

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
