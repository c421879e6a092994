"""Nominal instants of the frames: from the counter, from stamps, from arrivals.

Implements Eqs. 18, 19 of docs/fused.md.
"""

from math import isfinite, nan

import numpy as np
from numpy.typing import NDArray

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions
from stillarm.controller.estimation.fused.filters.laws import LAWS, Law


class Dating:
    """Carries each law's nominal instant from frame to frame.

    nominal, elapsed: instant of the frame accepted last, and the time since the one before, by each law's clock, s;
    doubt_s, stamp_doubt_s: how uncertain this step of the clock's and of the stamps' law is, s. behind: frames by which
    the arrivals are behind the counter: so many may have been lost without being counted.
    """

    def __init__(
        self, frame_s: float, delay_s: float, spread_s: float = 0.0, assumed: Assumptions = ASSUMPTIONS
    ) -> None:
        """frame_s: nominal period of the frames; delay_s, spread_s: prior mean and spread of the capture delay."""
        self._assumed = assumed.count
        self._frame_s = frame_s
        # one frame late by chance is no jump of the counter
        self._mismatch = max(
            self._assumed.mismatch_frames, self._assumed.mismatch_spreads * spread_s / frame_s
        )
        self._delay_s = delay_s
        self.nominal: NDArray[np.float64] = np.zeros(LAWS)
        self.elapsed: NDArray[np.float64] = np.zeros(LAWS)
        self.doubt_s = self.stamp_doubt_s = 0.0
        self.stamped = self.started = False
        self.behind = 0
        self._frame = 0
        self._missing = 0.0  # frames by which the arrivals are behind the counter since a stall
        self._since_stall = -1  # frames; -1 without one
        self._stalled = 0.0  # frames by which the first one was
        self._received_s = 0.0
        self._captured_s = nan

    def change_period(self, factor: float) -> None:
        """The frames' period is not the one supposed, but `factor` times that."""
        self._frame_s *= factor

    def accept(self, sample: VisualSample, received_s: float, *, images_tell: bool = False) -> bool:
        """Move on to a frame; False for one that is a duplicate or came out of order.

        images_tell: whether the images would show a wrong count; then late arrivals alone change none.
        """
        self.doubt_s = self.stamp_doubt_s = 0.0
        arrivals = received_s - self._delay_s
        if not self.started:
            self.started = True
            self.nominal[:] = arrivals
            self.elapsed[:] = self._frame_s
        else:
            frames = sample.frame - self._frame
            if -self._assumed.reset_back < frames <= 0:
                return False
            passed = max(received_s - self._received_s, 0.0)
            in_frames = passed / self._frame_s
            slack = self._mismatch + self._assumed.mismatch_passed * in_frames
            if (
                frames < 0
                or frames - in_frames > slack
                or in_frames - frames > self._assumed.longest_stall_frames
            ):
                frames = max(1, round(in_frames))  # reset, jumped, or a count of arrivals with many lost
                self.doubt_s = self._assumed.recount_doubt_frames * self._frame_s
                self._since_stall = -1
            else:
                lost = self._lost(in_frames - frames, slack)
                self.behind = round(self._missing) if self._since_stall >= 0 else 0
                if lost and images_tell:
                    self.behind, self.doubt_s = lost, 0.0
                else:
                    frames += lost
            self.elapsed[Law.CLOCK] = frames * self._frame_s
            self.nominal[Law.CLOCK] += self.elapsed[Law.CLOCK]
            self._follow_stamp(sample.captured_s, frames * self._frame_s)
            self.elapsed[Law.STEADY :] = passed
            self.nominal[Law.STEADY :] = arrivals
        self._frame, self._received_s, self._captured_s = sample.frame, received_s, sample.captured_s
        return True

    def _lost(self, behind: float, slack: float) -> int:
        """Number of frames that a counter of arrivals has missed, known some frames after a late one. Frames behind a
        stall come in a burst. If they do not, the frame was not late: frames before it were lost.

        behind: by how many frames' time this one came later after the last than the counter says.
        """
        if self._since_stall < 0:
            if behind <= slack:
                return 0
            self._missing, self._since_stall, self._stalled = 0.0, 0, behind
        self._missing += behind
        self._since_stall += 1
        burst = self._missing < self._stalled - self._assumed.catches_up_frames
        if self._missing > slack and self._since_stall < (
            self._assumed.stall_frames if burst else 1 + self._assumed.no_burst_frames
        ):
            return 0
        lost = round(self._missing) if self._missing > slack else 0
        self._since_stall = -1
        if lost:
            self.doubt_s = self._assumed.recount_doubt_frames * self._frame_s
        return lost

    def _follow_stamp(self, captured_s: float, by_counter_s: float) -> None:
        step = captured_s - self._captured_s
        slack = self._assumed.stamp_mismatch_frames * self._frame_s + 0.5 * by_counter_s
        good = isfinite(step) and step > 0.0 and abs(step - by_counter_s) < slack
        if self.stamped and not good:
            self.stamp_doubt_s = self._assumed.stamp_doubt_frames * self._frame_s
        self.stamped = self.stamped or good
        self.elapsed[Law.STAMPS] = step if good else by_counter_s
        self.nominal[Law.STAMPS] += self.elapsed[Law.STAMPS]
