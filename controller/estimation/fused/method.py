"""The fused method: one call a cycle, and the estimate that it returns; docs/fused.md derives it.

Implements Eqs. 1, 42, 60, 61, 65 of docs/fused.md.
"""

from cmath import exp
from math import hypot, inf, isfinite, pi, sqrt

from stillarm.common.files.configuration import Fused
from stillarm.common.files.model import Model, length_of
from stillarm.controller.estimation.estimate import (
    DelayEstimate,
    Estimate,
    FrameDelay,
    Observation,
    Status,
    Trust,
)
from stillarm.controller.estimation.fused.accelerometer.sensor_health import AccelerometerHealth
from stillarm.controller.estimation.fused.arm.joint_input import JointInput
from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions
from stillarm.controller.estimation.fused.block_history import BlockHistory
from stillarm.controller.estimation.fused.frame_steps import FrameSteps
from stillarm.controller.estimation.fused.fusion.fusion import FrameFusion
from stillarm.controller.estimation.fused.measured_changes import MeasuredChanges
from stillarm.controller.estimation.fused.present import Present
from stillarm.controller.estimation.fused.sample_intake import SampleIntake

_DOUBTFUL = "images lie further from what is predicted than the stated deviation allows"
_SCALE_DRIFTS = "images and accelerometer drift apart: the scene's depth, or the accelerometer's gain"
# Looked up once: to read an enumeration's member costs as much as a call.
_UNESTIMATED, _ESTIMATED, _HELD = Status.UNESTIMATED, Status.ESTIMATED, Status.HELD
_STARTING, _SETTLED, _DOUBTFUL_TRUST = Trust.STARTING, Trust.SETTLED, Trust.DOUBTFUL
OUT_OF_RANGE = "numbers out of range: started again"


class FusedMethod:
    """Accelerometer, images, frame counter, stamps, arrivals and joint motion in a bank of filters."""

    def __init__(
        self, model: Model, settings: Fused, model_name: str, assumed: Assumptions = ASSUMPTIONS
    ) -> None:
        """Raises UserError for a model without length."""
        self._model, self._settings, self._assumed = model, settings, assumed
        blocks = assumed.blocks
        self._length = length_of(model, model_name)
        self._cycle_s = model.timing.cycle_s
        self._at = Layout(model, self._length)
        self._w: list[float] = self._at.w.tolist()
        shortest = (
            2.0
            * pi
            / self._cycle_s
            * min(blocks.first_periods / self._w[0], blocks.highest_periods / max(self._w))
        )
        self._block_cycles = min(max(round(shortest), blocks.fewest_cycles), blocks.most_cycles)
        self._most_blocks = int(
            (model.timing.capture_delay_s + blocks.backlog_s) / (self._block_cycles * self._cycle_s)
        )
        self._begin()

    def _begin(self) -> None:
        """Everything unknown."""
        model, at, cycle_s, assumed = self._model, self._at, self._cycle_s, self._assumed
        per_sample = 1.0 / at.w_first**2 / abs(model.accelerometer.scale)
        health = AccelerometerHealth(
            per_sample * model.accelerometer.noise_std_m_s2,
            model.accelerometer.range_m_s2,
            per_sample * assumed.samples.least_noise_m_s2,
            per_sample,
            assumed,
        )
        self.frames = FrameFusion(model, self._settings, at, self._length, health, assumed)
        self._joint_input = JointInput(self._w, at.input_gain, cycle_s, assumed)
        self._history = BlockHistory(
            at, cycle_s, self._block_cycles * cycle_s, self.frames, self._joint_input
        )
        self._steps = FrameSteps(self.frames, self._history, self._joint_input)
        changes = MeasuredChanges(at, cycle_s, self.frames, self._history, self._steps, self._joint_input)
        self._intake = SampleIntake(
            model, at, self._length, health, self._history, self._joint_input, changes, assumed
        )
        self._stated = StatedEstimate(self._settings, self.frames, self._steps, self._history.present)

    @property
    def reason(self) -> str:
        """Why the last estimate has the status that it has."""
        return self._stated.reason

    def update(self, observation: Observation) -> Estimate:
        """One cycle: its sample of the accelerometer, and either a block's end, a frame, or a step of the last one."""
        cycle, time_s, joint = observation.cycle, observation.time_s, observation.joint
        turn = [exp(1j * w * time_s) for w in self._w]
        self._joint_input.advance(cycle, turn, joint.mean_acceleration_rad_s2, joint.position_rad)
        history, steps = self._history, self._steps
        steps.now_s = time_s
        if not history.begun:
            history.begin(cycle, time_s)
        history.present.advance(self._joint_input.increment)
        self._intake.see(observation, turn)
        closes = cycle - history.start_cycle >= self._block_cycles
        if closes:
            self._close_block(cycle)
        if observation.samples:
            steps.see(observation.samples)
        elif not closes:
            steps.work_off()
        estimate = self._stated.say(turn, time_s)
        if estimate is None:
            self._begin()
            estimate = self._stated.out_of_range()
        return estimate

    def see_new_zero(self) -> None:
        """OutlivesSupervisor: the dates, the arm and the accelerometer are as they were."""
        self._steps.finish_frame()
        self._steps.finish_update()
        self.frames.see_new_zero()
        self._history.forget_snapshot()

    def _close_block(self, cycle: int) -> None:
        """End the block under way, and see whether the present agrees with it."""
        history = self._history
        block = history.close(cycle)
        if self._intake.impact_under_way:
            self._intake.hold_back(block)
        if block.count:
            history.compare(block)
        if len(history) > self._most_blocks:
            self._steps.update_by_oldest_block()
            history.forget_taken()
        history.widen_present(block)


class StatedEstimate:
    """Deflection and delay with their deviations, status and trust.

    reason: why the last estimate has the status that it has.
    """

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
        if (
            state.blind and not self._known
        ):  # all hangs on the configured delay, which no filter's phasor contains
            std = hypot(std, rate * delay_std_s, 0.5 * deflection * (self._w_first * delay_std_s) ** 2)
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
        """The estimate that replaces one whose numbers are not finite."""
        self.reason = OUT_OF_RANGE
        state = self._fusion.state
        delay = DelayEstimate(state.delay_s, state.delay_std_s, Status.INVALID)
        return Estimate(delay, status=Status.INVALID, reason=self.reason)

    def _status(self, delay_std_s: float, amplitude_m: float, std_m: float, time_s: float) -> Status:
        """Status of the delay; sets the reason for it."""
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
