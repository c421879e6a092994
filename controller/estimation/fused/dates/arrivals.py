"""How steadily frames arrive, or are begun, at their exposure: white spread and wander, from differences.

Implements Eq. 24 of docs/fused.md.

The structure function D(n) = mean (d_k - d_(k-n))^2 of a white spread of variance v and a random walk of variance q per
second is 2 v + q n T (the idea of the Allan variance: D. W. Allan, Proc. IEEE 54, 1966). A walk smaller than its own
error counts as none.
"""

from collections import deque
from math import sqrt

from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions


class ArrivalSpread:
    """White variance, s^2, and walk, s^2/s, of arrival, or n_i, minus nominal instant of exposure.

    early: whether fewer differences than usual have to tell them.
    """

    def __init__(
        self, frame_s: float, spread_s: float, cycle_s: float, assumed: Assumptions = ASSUMPTIONS
    ) -> None:
        """spread_s: what the model says; it stands for both until the differences tell."""
        self._assumed = assumed.arrivals
        self.early = False
        self._frame_s = frame_s
        self._least = cycle_s * cycle_s / 12.0  # arrivals are read once a cycle
        self._first = spread_s * spread_s
        self._past: deque[float] = deque(maxlen=self._assumed.long_frames)
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
            self._short += (square - self._short) / min(float(self._shorts), self._assumed.memory_frames)
            self._steady_short += (square - self._steady_short) / min(
                float(self._shorts), self._assumed.long_memory_frames
            )
        if len(past) >= self._assumed.middle_frames:
            self._middles += 1
            square = (difference_s - past[-self._assumed.middle_frames]) ** 2
            self._middle += (square - self._middle) / min(
                float(self._middles), self._assumed.long_memory_frames
            )
        if len(past) >= self._assumed.long_frames:
            self._longs += 1
            square = (difference_s - past[-self._assumed.long_frames]) ** 2
            self._long += (square - self._long) / min(float(self._longs), self._assumed.long_memory_frames)
        past.append(difference_s)

    @property
    def known(self) -> bool:
        """Whether enough frames were seen to separate the walk from the white part."""
        return self._longs >= (self._assumed.enough_blind if self.early else self._assumed.enough)

    @property
    def white(self) -> float:
        """Variance of what changes from frame to frame, s^2."""
        return max(0.5 * self._short, self._least) if self._shorts > self._assumed.few else self._first

    @property
    def walk(self) -> float:
        """Growth of the variance of what lasts, s^2/s."""
        if not self.known:
            return self._first
        short = self._steady_short
        doubt = (
            self._assumed.doubt
            * short
            / sqrt(min(float(self._longs), 2.0 * self._assumed.long_memory_frames))
        )
        middle = (self._middle - short - doubt) / (self._assumed.middle_frames * self._frame_s)
        long = (self._long - short - doubt) / (self._assumed.long_frames * self._frame_s)
        return max(
            self._assumed.safety * middle,
            self._assumed.safety * long,
            self._assumed.least_walk * self._assumed.least_walk * 0.5 * short,
            1e-10,
        )
