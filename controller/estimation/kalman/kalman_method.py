"""The Kalman filters as methods: from the image alone [4, 9], or fused with a fast sensor [8].

The filter's belief refers to the instant of the last image. In each cycle a closed-form prediction carries it to the
present. The belief contains a fast sensor's samples up to that instant. A copy of it also contains the later samples.
"""

from math import nan, sqrt

import numpy as np

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import Kalman
from stillarm.common.files.model import Model, length_of
from stillarm.controller.estimation.estimate import Estimate, Observation, Status
from stillarm.controller.estimation.kalman.belief import Belief, first_belief, predicted, seen_from, updated
from stillarm.controller.estimation.kalman.fast_sensor import FastSensor, Reading
from stillarm.controller.estimation.kalman.forced_motion import ForcedMotion, image_shares
from stillarm.controller.estimation.kalman.rival import Rival
from stillarm.controller.estimation.kalman.two_time_scales import Densities, TwoTimeScales
from stillarm.controller.estimation.sine_method import DelayEstimator
from stillarm.controller.joint.joint_motion import JointMotion
from stillarm.controller.joint.known_image_motion import joint_image_rate_m_s
from stillarm.controller.joint.sensor_deflection import SensorDeflection

_LOST_S = 10.0  # without data for this time the vibration's phase is lost
_STALE_S = 0.25  # without data for this time the status is held
_LATEST_S = 0.5  # an image that is older than the filter's instant by more is not used
_IMPACT = 2  # images outside the gate in a row that indicate an impact
_RESTART_AFTER = 5  # an arm is not struck in four consecutive frames: the image has jumped
_LARGEST_IMPACT_M = 0.1  # an impact that would make the first mode ring wider counts as a jump, too
# without images the filter follows the fast sensor: starts at the first lag, goes to the second
_FAST_LAG_S = (0.4, 0.25)
_RATE_SPAN_S = 0.002
_OFFSET_DRIFT = 0.05  # of a fast sensor's offset per second, as a fraction of its noise
_LEAST_NOISE_M = 1e-6


class KalmanMethod:
    """Two-time-scale Kalman filter of all of the model's modes."""

    def __init__(
        self,
        model: Model,
        settings: Kalman,
        delay: DelayEstimator,
        model_name: str,
        reading: Reading | None = None,
    ) -> None:
        """delay: dates the samples. reading: the fast sensor to fuse with the image, if any."""
        length, cycle_s = length_of(model, model_name), model.timing.cycle_s
        modes = model.arm.modes
        self._delay = delay
        self._sensors = SensorDeflection(model, length)
        self._forced = ForcedMotion(model, length)
        noise = 0.0 if reading is None else reading.noise_std
        densities = Densities(
            settings.disturbance_m_s2**2 * 1e-3,
            settings.imposed_motion_m_s2**2 * 1e-3,
            (_OFFSET_DRIFT * noise) ** 2,
        )
        self._model = TwoTimeScales(modes, densities, None if reading is None else reading.offset_prior_std)
        self._density = densities.modes
        self._fast = None if reading is None else FastSensor(self._model, reading, cycle_s)
        self._row = np.zeros(self._model.size)
        self._row[0 : self._model.slow : 2] = image_shares(model, length)
        self._row[self._model.slow] = 1.0
        self._noise_m_per_px = abs(self._sensors.of_image(1.0, 0.0))
        self._noise_px = model.camera.noise_std_px
        self._frame_s = 1.0 / model.camera.frame_rate_hz
        self._w = modes[0].angular_frequency
        self._largest_impact = (self._w * _LARGEST_IMPACT_M) ** 2  # as a variance of the rate
        # until then vibration and offset are not distinguishable
        self._settled_s = 0.5 / modes[0].frequency_hz
        self._belief: Belief | None = None
        self._present: Belief | None = None  # the belief with the fast sensor's newest samples
        self._unpacked: Belief | None = None  # whose numbers the next two lists hold
        self._state: list[float] = []
        self._covariance: list[list[float]] = []
        self._refreshed_s = self._started_s = self._image_s = self._good_s = float("-inf")
        self._read_s = float("-inf")
        self._next_cycle = 0
        self._rival: Rival | None = None
        self._frame = -1
        self._outside_gate = 0

    def update(self, observation: Observation) -> Estimate:
        """Process one cycle: new samples at their own time, then the present."""
        self._forced.see_cycle(observation)
        if self._fast is not None:
            self._fast.see_cycle(observation, self._forced)
        for sample in observation.samples:
            if sample.measured:
                self._take(sample, observation)
        if self._fast is not None and self._belief is not None:
            self._catch_up(self._fast, self._belief, observation)
        return self._predict(observation)

    def _take(self, sample: VisualSample, observation: Observation) -> None:
        """Process a measured image at its capture instant."""
        joint, time_s = observation.joint, observation.time_s
        self._delay.see_sample(sample, observation.cycle, nan)
        captured = time_s - self._delay.estimate.delay_s
        seen = self._sensors.of_image(sample.displacement_x_px, joint.position_at(captured))
        value = seen - self._forced.image_deflection_at(joint, captured)
        restarted, self._frame = sample.frame < self._frame, sample.frame
        last_seen = max(self._read_s, float("-inf") if self._fast is None else self._fast.last_seen_s)
        belief = self._belief
        if belief is None or restarted or time_s - last_seen > _LOST_S:
            self._begin(captured, value)
        elif captured > belief.time_s - _LATEST_S:
            self._correct(belief, sample, observation, captured, value)
        self._read_s = time_s
        self._refreshed_s = min(self._refreshed_s, time_s - self._frame_s)

    def _begin(self, captured: float, value: float) -> None:
        self._belief = first_belief(self._model, captured, value)
        self._started_s = self._image_s = self._good_s = captured
        self._outside_gate = 0
        self._rival = None
        self._next_cycle = self._cycle_after(captured)

    def _cycle_after(self, time_s: float) -> int:
        return 0 if self._fast is None else self._fast.cycle_of(time_s) + 1

    def _advanced(self, belief: Belief, next_cycle: int, captured: float) -> tuple[Belief, int]:
        """The belief at an image's instant, with the fast sensor's samples up to it, and the cycle of the next one."""
        if self._fast is None:
            return predicted(self._model, belief, captured), next_cycle
        last = self._fast.cycle_of(captured)
        return self._fast.applied(belief, next_cycle, last, captured), max(next_cycle, last + 1)

    def _correct(
        self, belief: Belief, sample: VisualSample, observation: Observation, captured: float, value: float
    ) -> None:
        impact_within = max(captured - self._good_s, self._frame_s) if self._outside_gate else None
        belief, self._next_cycle = self._advanced(belief, self._next_cycle, captured)
        self._belief = belief = self._measured(belief, sample, observation, captured, value, impact_within)
        self._outside_gate = self._outside_gate + 1 if belief.outside_gate else 0
        self._image_s = max(self._image_s, captured)
        self._challenge(belief, sample, observation, captured, value)
        if not self._outside_gate:
            self._good_s = self._image_s
        elif self._outside_gate >= _RESTART_AFTER or belief.covariance[1, 1] > self._largest_impact:
            rival = self._rival
            self._begin(captured, value)
            # the rival has restarted a few images earlier
            if rival is not None and not rival.belief.outside_gate:
                self._belief, self._next_cycle = rival.belief, rival.next_cycle
                self._started_s = rival.began_s

    def _measured(
        self,
        belief: Belief,
        sample: VisualSample,
        observation: Observation,
        captured: float,
        value: float,
        impact_within: float | None,
    ) -> Belief:
        row = seen_from(self._model, belief, self._row, captured)
        variance = self._variance(belief, sample, observation, captured)
        return updated(self._model, belief, row, value, variance, impact_within)

    def _challenge(
        self, belief: Belief, sample: VisualSample, observation: Observation, captured: float, value: float
    ) -> None:
        """Update the rival with the image; start one at an impact; replace the filter if the rival is better."""
        rival = self._rival
        if rival is not None:
            ahead, rival.next_cycle = self._advanced(rival.belief, rival.next_cycle, captured)
            rival.see(self._measured(ahead, sample, observation, captured, value, None), belief)
            if rival.decided:
                self._rival = None
            if rival.wins:
                self._belief, self._next_cycle = rival.belief, rival.next_cycle
                self._outside_gate = 0
                return
        if self._outside_gate == _IMPACT and (rival is None or rival.belief.outside_gate):
            first = first_belief(self._model, captured, value)
            self._rival = Rival(first, self._cycle_after(captured), self._settled_s, 2.0 * self._settled_s)

    def _variance(
        self, belief: Belief, sample: VisualSample, observation: Observation, captured: float
    ) -> float:
        """Variance of a sample, m^2: its own noise, and the dating error times the tip's motion in the image."""
        joint = observation.joint
        own = (
            sqrt(sample.variance_x_px2) if sample.variance_x_px2 > 0.0 else self._noise_px
        ) * self._noise_m_per_px
        rates = slice(1, self._model.slow, 2)
        rate = float(belief.state[rates].sum()) + self._known_rate(joint, captured)
        unknown = float(belief.covariance[rates, rates].sum())
        bend = self._w * self._w * float(belief.state[0 : self._model.slow : 2].sum())
        dating = self._delay.estimate.std_s
        of_dating = dating * dating * (rate * rate + unknown) + 0.75 * (bend * dating * dating) ** 2
        return max(own, _LEAST_NOISE_M) ** 2 + of_dating

    def _known_rate(self, joint: JointMotion, captured: float) -> float:
        """Rate of the motion that is subtracted from the image: the joint, and the modes' response to it, m/s."""
        forced = self._forced.image_deflection_at
        of_forced = forced(joint, captured + _RATE_SPAN_S) - forced(joint, captured - _RATE_SPAN_S)
        return joint_image_rate_m_s(self._sensors, joint, captured) + of_forced / (2.0 * _RATE_SPAN_S)

    def _catch_up(self, fast: FastSensor, belief: Belief, observation: Observation) -> None:
        """Update a copy of the belief with the fast sensor's samples after the last image.

        This runs in the cycle after an image, so that no cycle has to do both.
        """
        time_s = observation.time_s
        if time_s - belief.time_s > _FAST_LAG_S[0]:
            until = time_s - _FAST_LAG_S[1]
            last = fast.cycle_of(until)
            self._belief = belief = fast.applied(belief, self._next_cycle, last, until)
            self._rival = None
            self._next_cycle = max(self._next_cycle, last + 1)
        since = time_s - self._refreshed_s
        if since >= self._frame_s and (not observation.samples or since >= 2.0 * self._frame_s):
            self._present = fast.applied(belief, self._next_cycle, observation.cycle, time_s)
            self._refreshed_s = time_s

    def _predict(self, observation: Observation) -> Estimate:
        """The present estimate, from the newest belief."""
        delay, time_s, joint = self._delay.estimate, observation.time_s, observation.joint
        belief = self._belief if self._fast is None else self._present
        if belief is None or self._image_s - self._started_s < self._settled_s:
            return Estimate(delay)
        if belief is not self._unpacked:  # plain floats, for the cycles until the next belief
            self._unpacked = belief
            fast = slice(0, self._model.slow)
            self._state, self._covariance = (
                belief.state[fast].tolist(),
                belief.covariance[fast, fast].tolist(),
            )
        elapsed = max(0.0, time_s - belief.time_s)
        state = self._state
        deflection = rate = bend = added = 0.0
        row: list[float] = []
        for i, mode in enumerate(self._model.modes):
            qq, qv, vq, vv = mode.transition(elapsed)
            q, v = qq * state[2 * i] + qv * state[2 * i + 1], vq * state[2 * i] + vv * state[2 * i + 1]
            deflection, rate, bend = deflection + q, rate + v, bend + mode.angular_frequency**2 * q
            row += (qq, qv)
            added += mode.scatter(elapsed).qq
        variance = added * self._density + max(0.0, quadratic_form(self._covariance, row))
        misdated = delay.std_s * delay.std_s * (rate * rate + 0.75 * (bend * delay.std_s) ** 2)
        return Estimate(
            delay,
            deflection + self._forced.deflection_m(joint),
            rate + self._forced.rate_m_s(joint),
            sqrt(variance + misdated),
            self._status(time_s),
        )

    def _status(self, time_s: float) -> Status:
        """The status; held while neither the camera nor the fast sensor delivers data."""
        fast_s = float("-inf") if self._fast is None else self._fast.last_seen_s
        return Status.HELD if time_s - max(self._read_s, fast_s) > _STALE_S else Status.ESTIMATED


def quadratic_form(matrix: list[list[float]], row: list[float]) -> float:
    """row @ matrix @ row for a symmetric matrix; for a few numbers plain floats are faster than numpy."""
    total = 0.0
    for i, (line, a) in enumerate(zip(matrix, row, strict=True)):
        cross = 0.0
        for j in range(i):
            cross += line[j] * row[j]
        total += a * (line[i] * a + 2.0 * cross)
    return total
