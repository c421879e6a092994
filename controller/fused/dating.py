"""Nominal instants of the frames: from the counter, from stamps, from arrivals (docs/fused.md, section 2)."""

from math import isfinite

import numpy as np
from numpy.typing import NDArray

from common.visual_sample import VisualSample
from controller.fused.bank import LAWS, Law

_RESET_BACK = 8  # a counter that falls by more than this was reset; by less, the frame is an old one
_LONGEST_PAUSE_FRAMES = 20.0
_MISMATCH_FRAMES = 2.5


class Dating:
    """Carries each law's nominal instant from frame to frame."""

    def __init__(self, frame_s: float, delay_s: float) -> None:
        """frame_s: nominal period of the frames; delay_s: prior mean of the capture delay."""
        self.frame_s = frame_s
        self._delay_s = delay_s
        self.nominal: NDArray[np.float64] = np.zeros(LAWS)
        self.elapsed: NDArray[np.float64] = np.zeros(LAWS)
        self.doubt_s = 0.0  # how uncertain the count of frames is beyond what the filters know, s
        self.stamped = False
        self.started = False
        self._frame = 0
        self._received_s = 0.0
        self._captured_s = float("nan")
        self.stamp_broken = False

    def accept(self, sample: VisualSample, received_s: float) -> bool:
        """Move on to a frame; False for one that is a duplicate or came out of order. Fills nominal and elapsed."""
        self.doubt_s = 0.0
        self.stamp_broken = False
        arrivals = received_s - self._delay_s
        if not self.started:
            self.started = True
            self.nominal[:] = arrivals
            self.elapsed[:] = self.frame_s
        else:
            frames = sample.frame - self._frame
            if -_RESET_BACK < frames <= 0:
                return False
            passed = (received_s - self._received_s) / self.frame_s
            if frames < 0 or abs(frames - passed) > _MISMATCH_FRAMES + 0.02 * passed:
                frames = max(1, round(passed))  # reset, jumped, or a counter of arrivals: the clock on the wall decides
                self.doubt_s = 0.7 * self.frame_s
            count = float(frames)
            self.elapsed[:] = count * self.frame_s
            self.nominal[Law.CLOCK] += self.elapsed[Law.CLOCK]
            self._follow_stamp(sample.captured_s, count * self.frame_s)
            self.elapsed[Law.STEADY :] = max(received_s - self._received_s, 0.0)
            self.nominal[Law.STEADY :] = arrivals
        self._frame, self._received_s, self._captured_s = sample.frame, received_s, sample.captured_s
        return True

    def _follow_stamp(self, captured_s: float, by_counter_s: float) -> None:
        step = captured_s - self._captured_s
        good = isfinite(step) and 0.0 < step and abs(step - by_counter_s) < 3.0 * self.frame_s + 0.5 * by_counter_s
        self.stamp_broken = self.stamped and not good
        self.stamped = self.stamped or good
        if good:
            self.elapsed[Law.STAMPS] = step
        self.nominal[Law.STAMPS] += self.elapsed[Law.STAMPS]
