"""How steadily frames arrive, or are begun, at their exposure: white spread and wander, from differences.

The structure function D(n) = mean (d_k - d_(k-n))^2 of a white spread of variance v and a random walk of variance q per
second is 2 v + q n T (the idea of the Allan variance: D. W. Allan, Proc. IEEE 54, 1966). What is less than its own
error is taken for no walk.
"""

from collections import deque
from math import sqrt

_MIDDLE, _LONG = 64, 256  # frames
_MEMORY, _LONG_MEMORY = 300.0, 2500.0  # frames
_ENOUGH = 64  # differences over the longest time
_DOUBT = 5.0  # two standard deviations of a difference of two such means: 2 * 1.22 * sqrt(2 * 2)
_LEAST_WALK = 0.005  # of the white spread, in a square root second
_SAFETY = 1.5  # the few independent differences of a drift make its walk uncertain


class ArrivalSpread:
    """White variance, s^2, and walk, s^2/s, of arrival, or n_i, minus nominal instant of exposure."""

    def __init__(self, frame_s: float, spread_s: float, cycle_s: float) -> None:
        """spread_s: what the model says; it stands for both until the differences tell."""
        self._frame_s = frame_s
        self._least = cycle_s * cycle_s / 12.0  # arrivals are read once a cycle
        self._first = spread_s * spread_s
        self._past: deque[float] = deque(maxlen=_LONG)
        self._short = self._steady_short = self._middle = self._long = 0.0
        self._shorts = self._middles = self._longs = 0

    def restart(self) -> None:
        """The count of frames has changed: differences across it mean nothing."""
        self._past.clear()

    def add(self, difference_s: float) -> None:
        """Arrival, or n_i, minus nominal instant of a frame, s."""
        past = self._past
        if past:
            self._shorts += 1
            square = (difference_s - past[-1]) ** 2
            self._short += (square - self._short) / min(float(self._shorts), _MEMORY)
            self._steady_short += (square - self._steady_short) / min(float(self._shorts), _LONG_MEMORY)
        if len(past) >= _MIDDLE:
            self._middles += 1
            square = (difference_s - past[-_MIDDLE]) ** 2
            self._middle += (square - self._middle) / min(float(self._middles), _LONG_MEMORY)
        if len(past) >= _LONG:
            self._longs += 1
            square = (difference_s - past[-_LONG]) ** 2
            self._long += (square - self._long) / min(float(self._longs), _LONG_MEMORY)
        past.append(difference_s)

    @property
    def known(self) -> bool:
        """Whether enough has been seen to tell what lasts from what does not."""
        return self._longs >= _ENOUGH

    @property
    def white(self) -> float:
        """Variance of what changes from frame to frame, s^2."""
        return max(0.5 * self._short, self._least) if self._shorts > 16 else self._first

    @property
    def walk(self) -> float:
        """Growth of the variance of what lasts, s^2/s."""
        if not self.known:
            return self._first
        short = self._steady_short
        doubt = _DOUBT * short / sqrt(min(float(self._longs), 2.0 * _LONG_MEMORY))
        middle = (self._middle - short - doubt) / (_MIDDLE * self._frame_s)
        long = (self._long - short - doubt) / (_LONG * self._frame_s)
        return max(_SAFETY * middle, _SAFETY * long, _LEAST_WALK * _LEAST_WALK * 0.5 * short, 1e-10)
