"""The accelerometer's raw samples, one a cycle: checked, bounded, and summed up in the block under way.

Implements Eqs. 9, 10 of docs/fused.md.
"""

from cmath import exp
from math import inf, sqrt

from stillarm.common.files.model import Model
from stillarm.controller.estimation.estimate import Observation
from stillarm.controller.estimation.fused.accelerometer.blocks import Block
from stillarm.controller.estimation.fused.accelerometer.impact_meter import ForceStep, ImpactMeter
from stillarm.controller.estimation.fused.accelerometer.sensor_health import AccelerometerHealth
from stillarm.controller.estimation.fused.arm.joint_input import JointInput
from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.assumptions.assumptions import Assumptions
from stillarm.controller.estimation.fused.block_history import BlockHistory
from stillarm.controller.estimation.fused.measured_changes import MeasuredChanges


class SampleIntake:
    """Sums up good samples; while an impact may be under way its samples and their blocks are held back."""

    def __init__(
        self, model: Model, at: Layout, length_m: float, health: AccelerometerHealth, history: BlockHistory,
        joint_input: JointInput, changes: MeasuredChanges, assumed: Assumptions,
    ) -> None:  # fmt: skip
        """No sample yet. health: judges each; history: has the block under way; changes: told of measured impacts."""
        sensor, cycle_s = model.accelerometer, model.timing.cycle_s
        w: list[float] = at.w.tolist()
        self._sensor, self._cycle_s = sensor, cycle_s
        self._health, self._history = health, history
        self._joint_input, self._changes = joint_input, changes
        self._modes = len(w)
        self._per_acceleration = -1.0 / at.w_first**2
        self._rigid = (1.0 - sum(mode.participation for mode in model.arm.modes)) * length_m
        self._nominal_gain = [
            self._per_acceleration * (-s + 1j * one) ** 2 for s, one in zip(at.sigma.tolist(), w, strict=True)
        ]
        # an impact on a high mode shows little deflection and much acceleration
        highest = max(w) / w[0]
        self._allowance = assumed.samples.allowance * highest**2 if len(w) > 1 else 0.0
        filter_cycles = round(sensor.delay_s / cycle_s)
        self._filter_turn = [exp(-1j * one * filter_cycles * cycle_s) for one in w] if filter_cycles else []
        self._meter = ImpactMeter(w[0], cycle_s, assumed)
        self._held_back: list[tuple[Block, int]] = []  # with how many samples

    def see(self, observation: Observation, turn: list[complex]) -> None:
        """Process a cycle's sample, where exp(i w t) is `turn`."""
        raw, sensor = observation.acceleration_m_s2, self._sensor
        history, health = self._history, self._health
        if self._filter_turn:
            turn = [one * back for one, back in zip(turn, self._filter_turn, strict=True)]
        present = history.present
        expected = present.expected(turn)
        rigid = self._rigid * observation.joint.acceleration_rad_s2
        expected_raw = (expected / self._per_acceleration + rigid) * sensor.scale + sensor.bias_m_s2
        if not health.usable(raw, expected_raw):
            return
        value = ((raw - sensor.bias_m_s2) / sensor.scale - rigid) * self._per_acceleration
        scatter = value - expected
        if not self._measure_impact(observation.cycle, scatter):
            value = expected + health.bounded(scatter, self._allowance * abs(present.z[0]))
            scatter = health.scatter(scatter)
        forced, sums, start_sums, gains = 0.0, self._joint_input.sum, history.start_sum, self._nominal_gain
        for i, one in enumerate(turn):
            forced += ((sums[i] - start_sums[i]) * one * gains[i]).real
        history.sums.add(value, turn, observation.time_s - sensor.delay_s, forced, scatter)

    @property
    def impact_under_way(self) -> bool:
        """Whether the samples may show an impact, and so are no part of any block yet."""
        return self._meter.open

    def _measure_impact(self, cycle: int, excess_m: float) -> bool:
        """Whether an impact is under way, whose samples are no part of any block."""
        meter, health, history = self._meter, self._health, self._history
        was_open = meter.open
        std = sqrt(health.variance)
        if health.mute or self._modes > 1 or history.present.uncertain(std):
            meter.reset()
            return False
        impact = meter.see(cycle, excess_m, std)
        if meter.open and not was_open:
            for block in history.later_than(meter.since * self._cycle_s):
                self.hold_back(block)
        if was_open and not meter.open:
            time_s = cycle * self._cycle_s
            # A sensor that dies shows a step, too: a force is let go only if images have shown one.
            unfounded = isinstance(impact, ForceStep) and not self._changes.force_held
            if impact is None or unfounded or not health.alarm(time_s, inf):
                self._give_back()
            else:
                history.sums.clear()
                self._held_back.clear()
                self._changes.take(impact, time_s)
        return meter.open

    def hold_back(self, block: Block) -> None:
        """Leave a block out until it is known whether its samples show an impact, which is no vibration."""
        if block.count:
            self._held_back.append((block, block.count))
            block.count = 0

    def _give_back(self) -> None:
        """Use the samples held back after all: they show no impact."""
        for block, count in self._held_back:
            block.count = count
            self._history.compare_if_waiting(block)
        self._held_back.clear()
