"""A sensor without delay, in every cycle, for the fusion of [8]: an accelerometer or a strain gauge."""

from math import floor, isfinite, nan
from typing import Protocol

import numpy as np

from stillarm.common.files.model import Model
from stillarm.controller.estimation.estimate import Observation
from stillarm.controller.estimation.kalman.belief import Belief, predicted, updated_by_batch
from stillarm.controller.estimation.kalman.forced_motion import ForcedMotion
from stillarm.controller.estimation.kalman.two_time_scales import TwoTimeScales, Vector
from stillarm.controller.joint.history import CycleHistory

HELD_S = 0.6  # length of the stored samples
_BATCH = 100  # samples per batch; disturbances are assumed to act at the batch's start


class Reading(Protocol):
    """A sensor's model of the free vibration: row(modes) @ (q_1, q_1', ...) + offset + noise."""

    noise_std: float
    offset_prior_std: float
    delay_s: float

    def row(self, model: TwoTimeScales) -> Vector:
        """Shape (size,)."""

    def value(self, observation: Observation, forced: ForcedMotion) -> float:
        """The free vibration in a cycle as measured; NaN without a measurement."""


class AccelerometerReading:
    """sum of - w^2 q - 2 zeta w q', m/s^2: s'' without the effect of the joint's motion."""

    offset_prior_std = 2.0  # m/s^2: a bias, and gravity in a tilted sensor

    def __init__(self, model: Model) -> None:
        """Use the model's accelerometer."""
        self._sensor = model.accelerometer
        self._modes = model.arm.modes
        self.noise_std = max(self._sensor.noise_std_m_s2 / abs(self._sensor.scale), 1e-3)
        self.delay_s = self._sensor.delay_s

    def row(self, model: TwoTimeScales) -> Vector:
        """Accelerations of the modes, and the offset."""
        row = np.zeros(model.size)
        for i, mode in enumerate(self._modes):
            w = mode.angular_frequency
            row[2 * i], row[2 * i + 1] = -w * w, -2.0 * mode.damping_ratio * w
        row[-1] = 1.0
        return row

    def value(self, observation: Observation, forced: ForcedMotion) -> float:
        """The measured value; NaN for a sample at the end of the sensor's range."""
        sensor, measured = self._sensor, observation.acceleration_m_s2
        if not abs(measured) < sensor.range_m_s2:
            return nan
        of_tip = (measured - sensor.bias_m_s2) / sensor.scale
        return of_tip - forced.tip_acceleration_m_s2(observation.joint)


class StrainGaugeReading:
    """sum of q, m, as measured by a strain gauge at the root."""

    offset_prior_std = 0.1  # m
    delay_s = 0.0

    def __init__(self, noise_std_m: float) -> None:
        """noise_std_m: of one cycle."""
        self.noise_std = noise_std_m

    def row(self, model: TwoTimeScales) -> Vector:
        """Deflections of the modes, and the offset."""
        row = np.zeros(model.size)
        row[0 : model.slow : 2] = 1.0
        row[-1] = 1.0
        return row

    def value(self, observation: Observation, forced: ForcedMotion) -> float:
        """The measured deflection; NaN without a measurement."""
        measured = observation.deflection_m
        return measured - forced.deflection_m(observation.joint) if isfinite(measured) else nan


class FastSensor:
    """The last samples of a sensor, and the updates of a belief with them."""

    def __init__(self, model: TwoTimeScales, reading: Reading, cycle_s: float) -> None:
        """cycle_s: time from one sample to the next."""
        self._model = model
        self._reading = reading
        self._cycle_s = cycle_s
        row = reading.row(model) / reading.noise_std
        back = [row @ model.transition(-k * cycle_s) for k in range(_BATCH)]
        self._rows = np.array(back[::-1])  # the last row belongs to the newest sample
        self._length = int(HELD_S / cycle_s) + 2
        self._history = CycleHistory(self._length, nan)
        self._cycle: int | None = None
        self.last_seen_s = float("-inf")

    def see_cycle(self, observation: Observation, forced: ForcedMotion) -> None:
        """Process a cycle; skipped cycles have no sample."""
        cycle = observation.cycle
        if self._cycle is not None:
            self._history.fill(cycle - 1, nan)
        self._cycle = cycle
        value = self._reading.value(observation, forced)
        self._history.write(cycle, value / self._reading.noise_std)
        if isfinite(value):
            self.last_seen_s = observation.time_s

    def cycle_of(self, time_s: float) -> int:
        """The last cycle whose sample is not later than `time_s`."""
        return floor((time_s + self._reading.delay_s) / self._cycle_s + 1e-9)

    def applied(self, belief: Belief, first: int, last: int, until_s: float) -> Belief:
        """The belief after the samples of cycles first .. last, at `until_s` or at the last sample if that is later."""
        if self._cycle is not None:
            last = min(last, self._cycle)
            first = max(first, self._cycle - self._length + 1)
            while first <= last:
                end = min(last, first + _BATCH - 1)
                belief = self._batch(belief, first, end, self._cycle, until_s if end == last else 0.0)
                first = end + 1
        return predicted(self._model, belief, until_s)

    def _batch(self, belief: Belief, first: int, last: int, newest: int, until_s: float) -> Belief:
        start, end = belief.time_s, last * self._cycle_s - self._reading.delay_s
        belief = predicted(self._model, belief, max(end, until_s))
        values = self._history.lags(newest - last, newest - first)
        rows = self._rows[_BATCH - len(values) :]
        present = np.isfinite(values)
        if not present.all():
            values, rows = values[present], rows[present]
            if len(values) == 0:
                return belief
        if end < belief.time_s:
            rows = rows @ self._model.transition(end - belief.time_s)
        since = max(belief.time_s - start, self._cycle_s)
        return updated_by_batch(self._model, belief, rows, values, since)
