"""The paper's method with any delay estimator: date the samples, fit a sine, evaluate it at the present."""

from math import inf, nan, sqrt
from typing import Protocol

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import Regression
from stillarm.common.files.model import Model, length_of
from stillarm.controller.estimation.estimate import DelayEstimate, Estimate, Observation, Status
from stillarm.controller.estimation.prediction.exact_regression import ExactRegression
from stillarm.controller.estimation.prediction.image_offset import ImageOffset
from stillarm.controller.estimation.prediction.sine_regression import SineRegression
from stillarm.controller.joint.joint_motion import JointMotion
from stillarm.controller.joint.known_image_motion import forced_rate_m_s, joint_image_rate_m_s
from stillarm.controller.joint.sensor_deflection import SensorDeflection

_LONGEST_GAP_S = 0.25  # between two frames of one window
_REFILLED = 6  # samples after a cut of the window: a fit to fewer is useless
_AGAIN_PERIODS = 1.5  # two impacts are hardly ever so close


class DelayEstimator(Protocol):
    """Estimates the age of each visual sample at its reading."""

    estimate: DelayEstimate

    def see_cycle(self, cycle: int, vibration: float) -> None:
        """Process the accelerometer's deflection in a cycle, m; NaN without a sample."""

    def see_sample(self, sample: VisualSample, cycle: int, deflection_m: float) -> None:
        """Process a visual sample read in `cycle` and its deflection, m (plus an unknown constant)."""


class SineMethod:
    """Delay estimator and sine regression in series (the paper's Fig. 1)."""

    def __init__(self, model: Model, regression: Regression, delay: DelayEstimator, model_name: str) -> None:
        """Predict the first mode of `model` from samples dated by `delay`."""
        length = length_of(model, model_name)
        mode = model.arm.modes[0]
        self._cycle_s = model.timing.cycle_s
        self._w = mode.angular_frequency
        self._period_s = 1.0 / mode.frequency_hz
        self._broken_s = -inf
        self.delay = delay
        self._sensors = SensorDeflection(model, length)
        self._offset = ImageOffset(mode, regression.offset_time_s)
        noise, dating = self._sensors.noise_std_m, model.timing.capture_delay_std_s
        exact = ExactRegression(mode, noise, dating, regression.frequency_std_fraction)
        self._regression = SineRegression(
            mode,
            regression.frames,
            noise,
            dating,
            variable_window=regression.variable_window,
            exact=exact if regression.form == "exact" else None,
        )

    def update(self, observation: Observation) -> Estimate:
        """Process one cycle: date new samples, fit if there are any, and predict."""
        joint, sensors = observation.joint, self._sensors
        self.delay.see_cycle(observation.cycle, sensors.of_acceleration(observation.acceleration_m_s2, joint))
        for sample in observation.samples:
            if sample.measured:
                self._take(sample, observation)
        return self._predict(observation.time_s, joint)

    def _take(self, sample: VisualSample, observation: Observation) -> None:
        joint, time_s, sensors = observation.joint, observation.time_s, self._sensors
        assumed = time_s - self.delay.estimate.delay_s
        seen = sensors.of_image(sample.displacement_x_px, joint.position_at(assumed))
        self.delay.see_sample(sample, observation.cycle, seen)
        captured = time_s - self.delay.estimate.delay_s
        free = sensors.of_image(
            sample.displacement_x_px, joint.position_at(captured)
        ) - joint.forced_deflection_at(captured)
        known_rate = joint_image_rate_m_s(sensors, joint, captured) + forced_rate_m_s(joint, captured)
        samples, offset = self._regression.samples, self._offset
        if self._regression.add(captured, free, offset.offset_m, _LONGEST_GAP_S, known_rate, offset.std_m):
            self._broken(captured, samples)
        self._offset.add(captured, free)

    def _broken(self, captured: float, samples: int) -> None:
        """A sample contradicts the fit to `samples`: an impact. If this repeats soon, the zero has moved as well."""
        again = captured - self._broken_s < _AGAIN_PERIODS * self._period_s and samples >= _REFILLED
        self._offset.forget_vibration()
        if again:
            self._offset.doubt(self._regression.predict(captured).amplitude_m)
        self._broken_s = captured

    def _predict(self, time_s: float, joint: JointMotion) -> Estimate:
        delay = self.delay.estimate
        if not self._regression.ready:
            return Estimate(delay, nan, nan, nan, Status.UNESTIMATED)
        free = self._regression.predict(time_s)
        of_delay = self._w * free.amplitude_m * delay.std_s / sqrt(2.0)
        return Estimate(
            delay,
            free.deflection_m + joint.forced_deflection_m,
            free.rate_m_s + joint.forced_rate_m_s,
            sqrt(free.std_m**2 + of_delay**2),
            Status.INVALID if delay.status is Status.INVALID else Status.ESTIMATED,
        )
