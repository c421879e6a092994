"""A moving average over a fixed number of cycles that skips missing values."""

from collections import deque
from math import isfinite


class MovingAverage:
    """Mean of the last `length` values; NaN counts as no value. Without any value the last mean is returned.

    The sum is recomputed once in each length, so that rounding errors do not accumulate over days.
    """

    def __init__(self, length: int) -> None:
        """Average over `length` values."""
        self._length = length
        self._values: deque[float] = deque([0.0] * length, maxlen=length)
        self._present: deque[bool] = deque([False] * length, maxlen=length)
        self._sum = 0.0
        self._count = 0
        self._since_fresh = 0
        self.mean = 0.0

    def add(self, value: float) -> float:
        """Add one value and return the mean."""
        if self._present[0]:
            self._sum -= self._values[0]
            self._count -= 1
        present = isfinite(value)
        self._values.append(value if present else 0.0)
        self._present.append(present)
        if present:
            self._sum += value
            self._count += 1
        self._since_fresh += 1
        if self._since_fresh >= self._length:
            self._since_fresh = 0
            self._sum = sum(self._values)
        if self._count:
            self.mean = self._sum / self._count
        return self.mean
