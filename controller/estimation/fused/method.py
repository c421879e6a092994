"""The fused method: one call a cycle; docs/fused.md derives it."""

from cmath import exp
from collections import deque
from enum import Enum
from math import hypot, inf, isfinite, pi, sqrt

from stillarm.common.datagrams.visual_sample import VisualSample
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
from stillarm.controller.estimation.fused.blocks import Block, BlockSums, Jump, along_rate
from stillarm.controller.estimation.fused.frames import FrameFusion, Merged
from stillarm.controller.estimation.fused.impact import Impact, ImpactDetector, ImpactReport
from stillarm.controller.estimation.fused.impact_meter import ForceStep, ImpactMeter, MeasuredImpact
from stillarm.controller.estimation.fused.joint_input import JointInput
from stillarm.controller.estimation.fused.layout import Layout
from stillarm.controller.estimation.fused.present import Present
from stillarm.controller.estimation.fused.sensor_health import AccelerometerHealth

_FIRST_PERIODS, _HIGHEST_PERIODS = (
    1.0 / 24.0,
    1.0 / 8.0,
)  # a block lasts, of the first and of the highest mode
_SHORTEST_BLOCK, _LONGEST_BLOCK = 3, 25  # cycles
_ALARM_S = 0.6
_USUAL_IMPACT_STDS = 10.0  # of a block's noise, at the least
_MOST_IMAGES = 2  # looked at in a cycle; of those before them only the dates count: no cycle may be long
_MOST_DATED = 4  # in a cycle, 0.1 to 0.25 ms each; those before them count as lost
_AHEAD_FRAMES = 0.9  # of an image are blocks taken in
_BACKLOG_S = 0.15  # of blocks, beyond the model's delay
_DOUBTFUL = "images lie further from what is predicted than the stated deviation allows"
_SCALE_DRIFTS = "images and accelerometer drift apart: the scene's depth, or the accelerometer's gain"


class _Work(Enum):
    """What the last frame has left to do."""

    NONE = 0
    DATE = 1
    ARRIVAL = 2
    STARTED = 3
    AIM = 4
    PREDICT = 5
    LOOK = 6
    TAKE = 7
    SETTLE = 8
    MERGE = 9
    PRESENT = 10
    LEARN = 11
    BLOCKS = 12


_OF_FRAME = frozenset(list(_Work)[_Work.DATE.value : _Work.MERGE.value])


class FusedMethod:
    """Accelerometer, images, frame counter, stamps, arrivals and joint motion in a bank of filters.

    reason: why the last estimate has the status that it has.
    """

    def __init__(self, model: Model, settings: Fused, model_name: str) -> None:
        """Raises UserError for a model without length."""
        self._model, self._settings = model, settings
        self._length = length_of(model, model_name)
        self._cycle_s = model.timing.cycle_s
        self._at = Layout(model, self._length)
        self._w: list[float] = self._at.w.tolist()
        self._sigma: list[float] = self._at.sigma.tolist()
        sensor = model.accelerometer
        self._per_acceleration = -1.0 / self._at.w_first**2
        self._rigid = (1.0 - sum(mode.participation for mode in model.arm.modes)) * self._length
        self._nominal_gain = [
            self._per_acceleration * (-s + 1j * w) ** 2 for s, w in zip(self._sigma, self._w, strict=True)
        ]
        # an impact to a high mode shows little deflection and much acceleration
        highest = max(self._w) / self._w[0]
        self._allowance = 0.2 * highest**2 if len(self._w) > 1 else 0.0
        self._filter_cycles = round(sensor.delay_s / self._cycle_s)
        self._filter_turn = [exp(-1j * w * self._filter_cycles * self._cycle_s) for w in self._w]
        shortest = (
            2.0 * pi / self._cycle_s * min(_FIRST_PERIODS / self._w[0], _HIGHEST_PERIODS / max(self._w))
        )
        self._block_cycles = min(max(round(shortest), _SHORTEST_BLOCK), _LONGEST_BLOCK)
        self._most_blocks = int(
            (model.timing.capture_delay_s + _BACKLOG_S) / (self._block_cycles * self._cycle_s)
        )
        self._frame_s = 1.0 / model.camera.frame_rate_hz
        self._now_s = 0.0
        self.reason = ""
        self._begin()

    def _begin(self) -> None:
        """Everything unknown."""
        model, at = self._model, self._at
        per_sample = abs(self._per_acceleration) / abs(model.accelerometer.scale)
        self.health = AccelerometerHealth(
            per_sample * model.accelerometer.noise_std_m_s2,
            model.accelerometer.range_m_s2,
            per_sample * 0.005,
            per_sample,
        )
        self.frames = FrameFusion(model, self._settings, at, self._length, self.health)
        self._joint_input = JointInput(self._w, at.input_gain, self._cycle_s)
        self._present = Present(self._w, self._sigma, at.w_first)
        self._impacts = ImpactDetector(self._w, self._block_cycles * self._cycle_s)
        self._impact_meter = ImpactMeter(self._w[0], self._cycle_s)
        self._sums = BlockSums(at.modes)
        self._blocks: deque[Block] = deque()
        self._held_back: list[tuple[Block, int]] = []  # with how many samples: a strike may be under way
        self._open_jumps: tuple[Jump, ...] = ()  # in the block under way
        self._block_start: int | None = None
        self._start_sum = [0j] * at.modes
        self._taken: list[Block] = []  # by the bank, since the snapshot
        self._snapshot: Merged | None = None
        self._work = _Work.NONE
        self._frame: tuple[VisualSample, float, bool] | None = (
            None  # read last; when, and whether its image counts
        )
        self._dated: list[
            tuple[int, float, float]
        ] = []  # in this cycle: frame, its delay, standard deviation
        self._last_instant_s = float("-inf")
        self._last_frame_s = self._alarm_s = float("-inf")
        self._known = False

    def update(self, observation: Observation) -> Estimate:
        """One cycle."""
        cycle, time_s, joint = observation.cycle, observation.time_s, observation.joint
        self._now_s = time_s
        turn = [exp(1j * w * time_s) for w in self._w]
        self._joint_input.advance(cycle, turn, joint.mean_acceleration_rad_s2, joint.position_rad)
        if self._block_start is None:
            self._block_start = cycle
            self.frames.bank.edge_s = time_s
            self._restart_present(time_s)
        present = self._present
        present.advance(self._joint_input.increment)
        self._see_acceleration(observation, turn)
        closes = cycle - self._block_start >= self._block_cycles
        if closes:
            self._close_block(cycle)
        samples = observation.samples
        if samples:
            self._see_samples(samples, time_s)
        elif not closes:
            self._work_off()
        return self._estimate(turn, time_s)

    def see_new_zero(self) -> None:
        """OutlivesSupervisor: the dates, the arm and the accelerometer are as they were."""
        while self._work in _OF_FRAME:
            self._work_off()
        self._take_what_was_seen()
        self.frames.see_new_zero()
        self._snapshot = None

    def _see_acceleration(self, observation: Observation, turn: list[complex]) -> None:
        raw, sensor = observation.acceleration_m_s2, self._model.accelerometer
        if self._filter_cycles:
            turn = [one * back for one, back in zip(turn, self._filter_turn, strict=True)]
        expected = self._present.expected(turn)
        rigid = self._rigid * observation.joint.acceleration_rad_s2
        expected_raw = (expected / self._per_acceleration + rigid) * sensor.scale + sensor.bias_m_s2
        if not self.health.usable(raw, expected_raw):
            return
        value = ((raw - sensor.bias_m_s2) / sensor.scale - rigid) * self._per_acceleration
        scatter = value - expected
        if not self._measure_strike(observation.cycle, scatter):
            value = expected + self.health.bounded(scatter, self._allowance * abs(self._present.z[0]))
            scatter = self.health.scatter(scatter)
        forced = 0.0
        for i, one in enumerate(turn):
            forced += ((self._joint_input.sum[i] - self._start_sum[i]) * one * self._nominal_gain[i]).real
        self._sums.add(value, turn, observation.time_s - sensor.delay_s, forced, scatter)

    def _measure_strike(self, cycle: int, excess_m: float) -> bool:
        """Whether a strike is under way, whose samples are no part of any block."""
        meter, was_open = self._impact_meter, self._impact_meter.open
        std = sqrt(self.health.variance)
        if self.health.mute or len(self._w) > 1 or self._present.uncertain(std):
            meter.reset()
            return False
        impact = meter.see(cycle, excess_m, std)
        if meter.open and not was_open:
            for block in self._blocks:
                if block.end_s > meter.since * self._cycle_s:
                    self._hold_back(block)
        if was_open and not meter.open:
            time_s = cycle * self._cycle_s
            # A sensor that dies shows a step, too: a force is let go only if images have shown one.
            without_held_force = isinstance(impact, ForceStep) and not self.frames.held_force.active
            if impact is None or without_held_force or not self.health.alarm(time_s, inf):
                self._give_back()
            else:
                self._sums.clear()
                self._held_back.clear()
                if isinstance(impact, ForceStep):
                    self._take_force_step(impact, time_s)
                else:
                    self._take_measured_impact(impact, time_s)
        return meter.open

    def _hold_back(self, block: Block) -> None:
        """Leave a block out until it is known whether its samples show a strike, which is no vibration."""
        if block.count:
            self._held_back.append((block, block.count))
            block.count = 0

    def _give_back(self) -> None:
        """The samples held back have shown no strike: what they do show counts."""
        for block, count in self._held_back:
            block.count = count
            if block in self._blocks:
                self._compare(block)
        self._held_back.clear()

    def _take_force_step(self, step: ForceStep, now_s: float) -> None:
        """A force that has begun, changed or ended, for all that is computed from its block on."""
        assert self._block_start is not None
        time_s = step.cycle * self._cycle_s
        self._impacts.forget()
        self.frames.held_force.step(step.size_m)
        jump = Jump.stepped(time_s, step.size_m)
        if time_s >= self._block_start * self._cycle_s:
            self._open_jumps += (jump,)
        else:
            block = next((one for one in reversed(self._blocks) if one.start_s <= time_s), None)
            if block is None:
                return  # images exposed since then have seen it
            block.jumps += (jump,)
        self._snapshot = None
        self._restart_present(now_s)

    def _take_measured_impact(self, impact: MeasuredImpact, now_s: float) -> None:
        """The strike's step of the phasors, at its own instant, for all that is computed from now on."""
        assert self._block_start is not None
        w, time_s = self._w[0], impact.cycle * self._cycle_s
        per_sum = self._at.w_first**2 * self._cycle_s / w  # of samples as deflection: velocity over w
        size, std = -impact.sum_m * per_sum, impact.sum_std_m * per_sum
        step = [size * along_rate(w, time_s)]
        across = abs(size) * w * impact.cycle_std * self._cycle_s
        jump = Jump(time_s, (std,), (min(across, std),))
        self._joint_input.add(time_s, step)
        self._impacts.forget()
        if time_s >= self._block_start * self._cycle_s:
            self._open_jumps += (jump,)
            self._restart_present(now_s)
            return
        self._start_sum = [one + more for one, more in zip(self._start_sum, step, strict=True)]
        known = (*self._taken, *self._blocks)
        block = next((one for one in reversed(known) if one.start_s <= time_s), None)
        if block is not None:
            block.step = tuple(one + more for one, more in zip(block.step, step, strict=True))
            block.jumps += (jump,)
        if block is None or block not in self._blocks:
            self._take_what_was_seen()
            self.frames.finish_block()
            self.frames.bank.add(step)
            self.frames.bank.inflate(jump)
            self._snapshot = None if block is None else self._snapshot
        self._restart_present(now_s)

    def _close_block(self, cycle: int) -> None:
        assert self._block_start is not None
        start_s, end_s = self._block_start * self._cycle_s, cycle * self._cycle_s
        sums = self._joint_input.sum
        step = tuple(now - then for now, then in zip(sums, self._start_sum, strict=True))
        block = self._sums.close(start_s, end_s, self.health.variance, step)
        self._block_start, self._start_sum = cycle, sums.copy()
        self._sums.clear()
        block.jumps, self._open_jumps = self._open_jumps, ()
        self._blocks.append(block)
        if self._impact_meter.open:
            self._hold_back(block)
        if block.count:
            self._compare(block)
        if len(self._blocks) > self._most_blocks:
            self._take_oldest_block()
            self._snapshot = None
            self._taken.clear()
        self._present.widen(self.frames.phasor_noise() * (end_s - start_s) + block.motion_variance)
        self._push(start_s, end_s)

    def _compare(self, block: Block) -> None:
        present = self._present
        residual = present.residual(block)
        if self.health.mute:
            return
        noise = block.variance * self.health.doubt
        variance = noise + present.bias_variance
        usual = max(abs(present.z[0]), _USUAL_IMPACT_STDS * sqrt(variance))
        impact = self._impacts.see(block, residual, variance, usual)
        if impact is None or not self.health.alarm(block.end_s, impact.excess):
            present.take_block(block, noise, self.frames.force.shown(block), at_end=True)
        else:
            self._mark(impact)

    def _mark(self, impact: Impact) -> None:
        """Let the blocks' history have the impact where it began, and see the present afresh."""
        self._impacts.forget()
        self._alarm_s = self._blocks[-1].end_s
        place = max(0, len(self._blocks) - impact.blocks_ago)
        block = self._blocks[place]
        block.jumps += (Jump.guessed(block.start_s, impact.sizes_m),)
        self._restart_present(self._blocks[-1].end_s)

    def _see_samples(self, samples: list[VisualSample], time_s: float) -> None:
        """Leave the last one to the cycles that follow; those before it have to be done with at once."""
        samples = samples[-_MOST_DATED:]
        first_looked_at = len(samples) - _MOST_IMAGES
        for place, sample in enumerate(samples):
            while self._work in _OF_FRAME:
                self._work_off()
            self._frame = sample, time_s, sample.measured and place >= first_looked_at
            self._work = _Work.DATE

    def _date_frame(self) -> None:
        assert self._frame is not None
        sample, received_s, _ = self._frame
        self._work = _Work.ARRIVAL if self.frames.accept(sample, received_s) else _Work.SETTLE

    def _take_arrival(self) -> None:
        self.frames.take_arrival()
        self._work = _Work.STARTED

    def _take_started(self) -> None:
        assert self._frame is not None
        self.frames.dates.take_started()
        self._work = _Work.AIM if self._frame[2] else _Work.SETTLE
        if self._frame[2]:
            instant_s = self.frames.dates.expected_instant_s()
            if not self._block_before(instant_s):
                self._aim_at(instant_s)  # little work, both

    def _block_before(self, time_s: float) -> bool:
        return bool(self._blocks) and self._blocks[0].end_s <= time_s

    def _aim_at_image(self) -> None:
        """The image that waits, once the blocks before it have been taken in."""
        instant_s = self.frames.dates.expected_instant_s()
        if self._block_before(instant_s):
            self._take_oldest_block()
        else:
            self._aim_at(instant_s)

    def _aim_at(self, instant_s: float) -> None:
        """The image that waits, exposed at instant_s, no block before it being left."""
        assert self._frame is not None
        sample, received_s, _ = self._frame
        self.frames.aim(sample, received_s, self._joint_input)
        self._last_instant_s = instant_s
        self._work = _Work.PREDICT

    def _predict_image(self) -> None:
        self.frames.predict_image()
        self._work = _Work.LOOK

    def _look_at_image(self) -> None:
        assert self._frame is not None
        frames, (sample, received_s, _) = self.frames, self._frame
        in_use = bool(self._blocks) and self._blocks[-1].count > 0 and not self.health.mute
        sees = in_use and self.health.sees_impacts and self._now_s - self._alarm_s > _ALARM_S
        of_use = frames.look(ImpactReport(self._impacts.suspicion, sees, in_use))
        self._last_frame_s = received_s
        if frames.impact:
            self._impacts.forget()
        self._work = _Work.TAKE if of_use else _Work.SETTLE
        if not of_use:
            self._tell_date(sample.frame)

    def _take_image(self) -> None:
        assert self._frame is not None
        self.frames.take()
        self._work = _Work.SETTLE

    def _settle(self) -> None:
        assert self._frame is not None
        if self.frames.settle():
            self._tell_date(self._frame[0].frame)
        self._work = _Work.MERGE

    def _take_oldest_block(self) -> None:
        self._take_what_was_seen()
        block = self._blocks.popleft()
        self.frames.take_block(block)
        self._taken.append(block)

    def _tell_date(self, frame: int) -> None:
        self._dated.append((frame, self.frames.delay_s, self.frames.delay_std_s))

    def _take_what_was_seen(self) -> None:
        """Before anything else changes the bank; what was only aimed at is aimed at anew."""
        if self._work in (_Work.PREDICT, _Work.LOOK):
            self._work = _Work.AIM
        if self._work is _Work.TAKE:
            self._take_image()
        if self._work is _Work.SETTLE:
            self._settle()

    def _work_off(self) -> None:
        """What a frame leaves to do, a part in each of the next cycles, so that none is long."""
        if not self.frames.leave_block():
            _PARTS[self._work](self)

    def _work_out_present(self) -> None:
        self._restart_present(self._now_s)
        self._work = _Work.LEARN

    def _learn(self) -> None:
        if self.frames.learn():
            self._snapshot = None
            self._restart_present(self._now_s)
        self._go_on_with_blocks()

    def _go_on_with_blocks(self) -> None:
        self._work = _Work.BLOCKS if self._block_ahead() else _Work.NONE

    def _take_block_ahead(self) -> None:
        if self._block_ahead():
            self._take_oldest_block()
        self._go_on_with_blocks()

    def _block_ahead(self) -> bool:
        """Whether there is a block that the next image will want taken in."""
        return self._block_before(self._last_instant_s + _AHEAD_FRAMES * self._frame_s)

    def _merge_filters(self) -> None:
        self._merge(self._now_s)
        self._work = _Work.PRESENT

    def _merge(self, now_s: float) -> None:
        self._snapshot = self.frames.merged(now_s)
        self._taken.clear()

    def _restart_present(self, now_s: float) -> None:
        """From the bank's instant to now."""
        if self._snapshot is None:
            self._merge(now_s)
        assert self._snapshot is not None
        merged, present = self._snapshot, self._present
        present.restart(
            list(merged.phasors), [row.copy() for row in merged.covariance], merged.slow,
            merged.bias, merged.bias_variance, merged.force, self._cycle_s,
        )  # fmt: skip
        for block in (*self._taken, *self._blocks):
            for jump in block.jumps:
                present.inflate(jump)
            if block.count and not self.health.mute:
                noise = block.variance * self.health.doubt
                present.take_block(block, noise, self.frames.force.shown(block), at_end=False)
            self._push(block.start_s, block.end_s)
            present.move_on(block)
            present.widen(block.motion_variance)
        assert self._block_start is not None
        for jump in self._open_jumps:
            present.inflate(jump)
        rest = now_s - self._block_start * self._cycle_s
        for i, start in enumerate(self._start_sum):
            turned = present.z[i] * exp(present.slow[i] * rest)
            present.z[i] = turned + self._joint_input.sum[i] - start

    def _push(self, start_s: float, end_s: float) -> None:
        """What a steady random force may have done to the present."""
        push = self.frames.force.during(start_s, end_s)
        if push is not None:
            self._present.inflate(push)
        held = self.frames.held_during(start_s, end_s)
        if held is not None:
            self._present.inflate(held)

    def _estimate(self, turn: list[complex], time_s: float) -> Estimate:
        deflection, rate, std = self._present.deflection(turn)
        consistency = self.frames.consistency
        std *= consistency.factor
        if not isfinite(deflection + rate + std):
            self._begin()
            self.reason = "numbers out of range: started again"
            delay = DelayEstimate(self.frames.delay_s, self.frames.delay_std_s, Status.INVALID)
            return Estimate(delay, status=Status.INVALID, reason=self.reason)
        frames = self.frames
        amplitude = sqrt(sum(abs(one) ** 2 for one in self._present.z))
        delay_std_s = frames.delay_std_s * consistency.factor
        suspected = abs(frames.suspected_rad)
        if suspected:  # by so much all of it may be off
            std = hypot(std, suspected * amplitude)
            delay_std_s = hypot(delay_std_s, suspected / self._at.w_first)
        status = Status.ESTIMATED
        self.reason = self.health.reason or (_SCALE_DRIFTS if frames.scale_drifts else "")
        known = delay_std_s <= self._settings.known_within_s
        self._known = self._known or known
        if not self._known:
            status, self.reason = Status.UNESTIMATED, "too little vibration seen yet"
        elif not known:
            status, self.reason = Status.HELD, self.health.reason or "the delay can no longer be seen"
        elif amplitude < max(self._settings.min_amplitude_m, 3.0 * std):
            status, self.reason = Status.HELD, "vibration too small to show the delay"
        elif time_s - self._last_frame_s > 0.25:
            status, self.reason = Status.HELD, "no images"
        delay = DelayEstimate(frames.delay_s, delay_std_s, status)
        dated: tuple[FrameDelay, ...] = ()
        if self._dated:
            dated = tuple(
                FrameDelay(frame, DelayEstimate(delay_s, std_s * consistency.factor, status))
                for frame, delay_s, std_s in self._dated
            )
            self._dated.clear()
        of_deflection = Status.UNESTIMATED if self._last_frame_s == float("-inf") else Status.ESTIMATED
        trust = Trust.SETTLED if self._known else Trust.STARTING
        if consistency.doubtful or suspected or frames.dates_doubted:
            trust, self.reason = Trust.DOUBTFUL, self.reason or _DOUBTFUL
        static_m = self._present.force
        return Estimate(
            delay, deflection, rate, std, of_deflection, self.reason, frames.blind, dated, static_m, trust
        )


_PARTS = {
    _Work.NONE: lambda method: None,
    _Work.DATE: FusedMethod._date_frame,
    _Work.ARRIVAL: FusedMethod._take_arrival,
    _Work.STARTED: FusedMethod._take_started,
    _Work.AIM: FusedMethod._aim_at_image,
    _Work.PREDICT: FusedMethod._predict_image,
    _Work.LOOK: FusedMethod._look_at_image,
    _Work.TAKE: FusedMethod._take_image,
    _Work.SETTLE: FusedMethod._settle,
    _Work.MERGE: FusedMethod._merge_filters,
    _Work.PRESENT: FusedMethod._work_out_present,
    _Work.LEARN: FusedMethod._learn,
    _Work.BLOCKS: FusedMethod._take_block_ahead,
}
