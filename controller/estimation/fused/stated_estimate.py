"""What the method says in a cycle: deflection and delay with their deviations, status, trust, and why.

Implements Eqs. 60, 61 of docs/fused.md.
"""

from math import hypot, isfinite, sqrt

from stillarm.common.files.configuration import Fused
from stillarm.controller.estimation.estimate import DelayEstimate, Estimate, FrameDelay, Status, Trust
from stillarm.controller.estimation.fused.frame_steps import FrameSteps
from stillarm.controller.estimation.fused.fusion.fusion import FrameFusion
from stillarm.controller.estimation.fused.present import Present

_DOUBTFUL = "images lie further from what is predicted than the stated deviation allows"
_SCALE_DRIFTS = "images and accelerometer drift apart: the scene's depth, or the accelerometer's gain"
OUT_OF_RANGE = "numbers out of range: started again"


class StatedEstimate:
    """reason: why the last estimate has the status that it has."""

    def __init__(self, settings: Fused, fusion: FrameFusion, frame: FrameSteps, present: Present) -> None:
        """The delay has never been known."""
        self._settings = settings
        self._fusion, self._frame, self._present = fusion, frame, present
        self._assumed = fusion.state.assumed.update
        self._w_first = fusion.state.at.w_first
        self._known = False
        self.reason = ""

    def say(self, turn: list[complex], time_s: float) -> Estimate | None:
        """The estimate at time_s, where exp(i w t) is `turn`; None where its numbers are out of range."""
        deflection, rate, std = self._present.deflection(turn)
        fusion = self._fusion
        state, consistency = fusion.state, fusion.consistency
        std = hypot(std, rate * state.sampled_s) * consistency.factor
        if not isfinite(deflection + rate + std):
            return None
        amplitude = sqrt(sum(abs(one) ** 2 for one in self._present.z))
        delay_std_s = state.delay_std_s * consistency.factor
        suspected = abs(state.date_watch.suspected_rad)
        if suspected:  # by so much all of it may be off
            std = hypot(std, suspected * amplitude)
            delay_std_s = hypot(delay_std_s, suspected / self._w_first)
        status = self._status(delay_std_s, amplitude, std, time_s)
        delay = DelayEstimate(state.delay_s, delay_std_s, status)
        last_frame_s = self._frame.last_frame_s
        of_deflection = Status.UNESTIMATED if last_frame_s == float("-inf") else Status.ESTIMATED
        trust = Trust.SETTLED if self._known else Trust.STARTING
        if consistency.doubtful or suspected or fusion.recovery.dates_doubted:
            trust, self.reason = Trust.DOUBTFUL, self.reason or _DOUBTFUL
        return Estimate(
            delay, deflection, rate, std, of_deflection, self.reason, state.blind,
            self._dated(status) if self._frame.dated else (), self._present.force, trust,
        )  # fmt: skip

    def out_of_range(self) -> Estimate:
        """What is said in place of numbers that are no numbers."""
        self.reason = OUT_OF_RANGE
        state = self._fusion.state
        delay = DelayEstimate(state.delay_s, state.delay_std_s, Status.INVALID)
        return Estimate(delay, status=Status.INVALID, reason=self.reason)

    def _status(self, delay_std_s: float, amplitude_m: float, std_m: float, time_s: float) -> Status:
        """Of the delay; sets the reason for it."""
        state, settings = self._fusion.state, self._settings
        health = state.health
        self.reason = health.reason or (_SCALE_DRIFTS if state.scale_watch.drifts else "")
        known = delay_std_s <= settings.known_within_s
        self._known = self._known or known
        if not self._known:
            self.reason = "too little vibration seen yet"
            return Status.UNESTIMATED
        if not known:
            self.reason = health.reason or "the delay can no longer be seen"
        elif amplitude_m < max(settings.min_amplitude_m, self._assumed.delay_shown_stds * std_m):
            self.reason = "vibration too small to show the delay"
        elif time_s - self._frame.last_frame_s > self._assumed.no_images_s:
            self.reason = "no images"
        else:
            return Status.ESTIMATED
        return Status.HELD

    def _dated(self, status: Status) -> tuple[FrameDelay, ...]:
        """The frames whose delay was told in this cycle."""
        factor = self._fusion.consistency.factor
        dated = tuple(
            FrameDelay(frame, DelayEstimate(delay_s, std_s * factor, status))
            for frame, delay_s, std_s in self._frame.dated
        )
        self._frame.dated.clear()
        return dated
