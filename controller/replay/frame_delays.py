"""Collects the delays of frames, which a method may report in the cycle of the reading or in a later one."""

from collections import deque
from collections.abc import Sequence

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.controller.estimation.estimate import MOST_UNDATED, DelayEstimate, Estimate


class FrameDelays:
    """Counts the frames from 0 in the order of their reading."""

    def __init__(self) -> None:
        """Start without frames."""
        self._count = 0
        self._awaited: deque[tuple[int, int]] = deque(maxlen=MOST_UNDATED)  # index, frame

    def told(self, samples: Sequence[VisualSample], estimate: Estimate) -> list[tuple[int, DelayEstimate]]:
        """Indices of frames with their latest delays. Call it once a cycle.

        samples: read in this cycle. A frame's index is returned once with them, and again when the estimate dates it.
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
