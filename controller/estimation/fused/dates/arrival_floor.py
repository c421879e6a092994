"""The floor of the arrivals by a clock: each arrival is the floor plus a wait that is never negative.

Implements Eq. 20 of docs/fused.md.

Waiting makes an image late, never early. A queue that drains at the start makes a run of images late by hundreds of
milliseconds. The floor of the arrivals therefore tells a clock's place, not their mean (one-way delays: Moon, Skelly
and Towsley, INFOCOM 1999). The floor is the least arrival of the last frames.
"""

from collections import deque

from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions


class ArrivalFloor:
    """Watches arrival minus nominal instant of the frames by a clock.

    fell: whether the arrival processed last was earlier by far than all before it, which then came late. mean_s: of the
    arrivals near the floor, s.
    """

    def __init__(self, spread_s: float, assumed: Assumptions = ASSUMPTIONS) -> None:
        """spread_s: of the capture delay from frame to frame."""
        self._assumed = assumed.arrivals
        self._spread_s = spread_s
        self.restart()

    def restart(self) -> None:
        """The count of frames has changed."""
        self._lowest: deque[tuple[int, float]] = deque()  # rising: the least of each stretch that ends now
        self._count = 0
        self.fell = False
        self.mean_s = 0.0

    def see(self, late_s: float) -> bool:
        """Process arrival minus nominal instant, s; whether it is near enough to the floor to tell of the clock."""
        lowest = self._lowest
        self._count += 1
        while lowest and lowest[0][0] <= self._count - self._assumed.floor_frames:
            lowest.popleft()
        floor = lowest[0][1] if lowest else late_s
        self.fell = late_s < floor - self._assumed.fell_spreads * self._spread_s
        while lowest and lowest[-1][1] >= late_s:
            lowest.pop()
        lowest.append((self._count, late_s))
        near = late_s < floor + self._assumed.above_spreads * self._spread_s
        if self.fell or self._count == 1:
            self.mean_s = late_s
        elif near:
            self.mean_s += (late_s - self.mean_s) / min(self._count, self._assumed.floor_mean_frames)
        return near
