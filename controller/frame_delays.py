"""Which cycle says the delay of a frame: the one that read it, or a later one where the method takes its time."""

from collections import deque
from collections.abc import Sequence

from common.visual_sample import VisualSample
from controller.estimate import MOST_UNDATED, DelayEstimate, Estimate


class FrameDelays:
    """Counts the frames from 0 in the order in which they are read."""

    def __init__(self) -> None:
        """None read yet."""
        self._count = 0
        self._awaited: deque[tuple[int, int]] = deque(maxlen=MOST_UNDATED)  # place, frame

    def told(self, samples: Sequence[VisualSample], estimate: Estimate) -> list[tuple[int, DelayEstimate]]:
        """Places of frames with the best that has been said of their delays yet; asked once a cycle.

        samples: read in this cycle. A frame's place comes once with them, and once more when the estimate dates it.
        """
        said = []
        for sample in samples:
            said.append((self._count, estimate.delay))
            self._awaited.append((self._count, sample.frame))
            self._count += 1
        for frame, delay in estimate.dated or ():
            awaited = next((one for one in self._awaited if one[1] == frame), None)
            if awaited is not None:
                self._awaited.remove(awaited)
                said.append((awaited[0], delay))
        return said
