"""How steadily frames arrive after their exposure: white spread and wander of the delay, from its differences.

The structure function D(n) = mean (d_k - d_(k-n))^2 of a white spread of variance v and a random walk of variance q per
second is 2 v + q n T (the idea of the Allan variance: D. W. Allan, Proc. IEEE 54, 1966).
"""

from collections import deque

_MIDDLE, _LONG = 64, 256  # frames
_MEMORY, _LONG_MEMORY = 300.0, 2500.0  # frames
_SAFETY = 1.5  # the few independent differences of a drift make its walk uncertain


class ArrivalSpread:
    """White variance, s^2, and walk, s^2/s, of arrival minus nominal instant of exposure."""

    def __init__(self, frame_s: float, spread_s: float, cycle_s: float) -> None:
        """spread_s: what the model says; it stands for both until the differences tell."""
        self._frame_s = frame_s
        self._least = cycle_s * cycle_s / 12.0  # arrivals are read once a cycle
        self._first = spread_s * spread_s
        self._past: deque[float] = deque(maxlen=_LONG)
        self._short = self._middle = self._long = 0.0
        self._shorts = self._middles = self._longs = 0

    def restart(self) -> None:
        """The count of frames has changed: differences across it mean nothing."""
        self._past.clear()

    def add(self, difference_s: float) -> None:
        """Arrival minus nominal instant of a frame, s."""
        past = self._past
        if past:
            self._shorts += 1
            square = (difference_s - past[-1]) ** 2
            self._short += (square - self._short) / min(float(self._shorts), _MEMORY)
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
    def white(self) -> float:
        """Variance of what changes from frame to frame, s^2."""
        return max(0.5 * self._short, self._least) if self._shorts > 16 else self._first

    @property
    def walk(self) -> float:
        """Growth of the variance of what lasts, s^2/s."""
        if self._longs < 64:
            return self._first
        middle = (self._middle - self._short) / (_MIDDLE * self._frame_s)
        long = (self._long - self._short) / (_LONG * self._frame_s)
        return max(_SAFETY * middle, _SAFETY * long, 1e-10)
