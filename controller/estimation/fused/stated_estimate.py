"""What the method says in a cycle: deflection and delay with their deviations, status, trust, and why.

Implements Eqs. 60, 61 of docs/fused.md.
"""

from math import hypot, inf, isfinite, sqrt

from stillarm.common.files.configuration import Fused
from stillarm.controller.estimation.estimate import DelayEstimate, Estimate, FrameDelay, Status, Trust
from stillarm.controller.estimation.fused.frame_steps import FrameSteps
from stillarm.controller.estimation.fused.fusion.fusion import FrameFusion
from stillarm.controller.estimation.fused.present import Present

_DOUBTFUL = "images lie further from what is predicted than the stated deviation allows"
_SCALE_DRIFTS = "images and accelerometer drift apart: the scene's depth, or the accelerometer's gain"
# Looked up once: to read an enumeration's member costs as much as a call.
_UNESTIMATED, _ESTIMATED, _HELD = Status.UNESTIMATED, Status.ESTIMATED, Status.HELD
_STARTING, _SETTLED, _DOUBTFUL_TRUST = Trust.STARTING, Trust.SETTLED, Trust.DOUBTFUL
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
        present, fusion = self._present, self._fusion
        deflection, rate, std = present.deflection(turn)
        state, consistency = fusion.state, fusion.consistency
        factor = consistency.factor
        std = hypot(std, rate * state.sampled_s) * factor
        if not isfinite(deflection + rate + std):
            return None
        square = 0.0
        for one in present.z:
            square += abs(one) ** 2
        amplitude = sqrt(square)
        delay_std_s = state.delay_std_s * factor
        suspected = abs(state.date_watch.suspected_rad)
        if suspected:  # by so much all of it may be off
            std = hypot(std, suspected * amplitude)
            delay_std_s = hypot(delay_std_s, suspected / self._w_first)
        status = self._status(delay_std_s, amplitude, std, time_s)
        delay = DelayEstimate(state.delay_s, delay_std_s, status)
        frame = self._frame
        of_deflection = _UNESTIMATED if frame.last_frame_s == -inf else _ESTIMATED
        trust = _SETTLED if self._known else _STARTING
        if consistency.doubtful or suspected or fusion.recovery.dates_doubted:
            trust, self.reason = _DOUBTFUL_TRUST, self.reason or _DOUBTFUL
        return Estimate(
            delay, deflection, rate, std, of_deflection, self.reason, state.blind,
            self._dated(status) if frame.dated else (), present.force, trust,
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
        if known:
            self._known = True
        elif not self._known:
            self.reason = "too little vibration seen yet"
            return _UNESTIMATED
        if not known:
            self.reason = health.reason or "the delay can no longer be seen"
        elif amplitude_m < max(settings.min_amplitude_m, self._assumed.delay_shown_stds * std_m):
            self.reason = "vibration too small to show the delay"
        elif time_s - self._frame.last_frame_s > self._assumed.no_images_s:
            self.reason = "no images"
        else:
            return _ESTIMATED
        return _HELD

    def _dated(self, status: Status) -> tuple[FrameDelay, ...]:
        """The frames whose delay was told in this cycle."""
        factor = self._fusion.consistency.factor
        dated = tuple(
            FrameDelay(frame, DelayEstimate(delay_s, std_s * factor, status))
            for frame, delay_s, std_s in self._frame.dated
        )
        self._frame.dated.clear()
        return dated
