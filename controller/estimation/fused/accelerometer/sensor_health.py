"""Judges the accelerometer: which samples are good, how much they count, and whether the sensor is alive.

Implements Eqs. 10, 14 of docs/fused.md.

Radiation makes a sensor noisy, lets it drift, clip, spike, stick, or die. Each is recognised by a test of its own;
`reason` names the gravest one found.
"""

from math import isfinite, sqrt

from stillarm.controller.estimation.fused.accelerometer.against_images import AgainstImages
from stillarm.controller.estimation.fused.accelerometer.clipping import Clipping
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions


class AccelerometerHealth:
    """Sorts out missing, stuck and clipped samples, bounds spikes, learns the noise, sees a dead sensor.

    variance: of a sample as deflection, m^2. mute: not to be used. reason: what is wrong with it, "" for nothing.
    """

    def __init__(
        self,
        noise_m: float,
        range_m_s2: float,
        least_m: float,
        m_per_m_s2: float,
        assumed: Assumptions = ASSUMPTIONS,
    ) -> None:
        """noise_m: standard deviation of a sample as deflection, m, as the model has it; least_m: a floor to it.

        m_per_m_s2: deflection that an acceleration of 1 m/s^2 stands for.
        """
        self._assumed, self._images = assumed.samples, assumed.against_images
        self._all_assumed = assumed
        self.variance = max(noise_m, least_m) ** 2
        self._stated = self.variance
        self._least = least_m**2
        self._m_per_m_s2 = m_per_m_s2
        self._clipping = Clipping(self._assumed.clipped * range_m_s2, assumed)
        self._against = AgainstImages(self._all_assumed)
        self._last = float("nan")
        self._same = self._missing = self._cut = 0
        self._spikes = self._alarms = 0.0
        self._alarm_s = float("-inf")
        self._drift = self._drifting = 0.0
        self.mute = False

    def usable(self, acceleration_m_s2: float, expected_m_s2: float) -> bool:
        """Whether a raw sample may be used at all. expected_m_s2: what it should be, for the limits of its range."""
        if not isfinite(acceleration_m_s2):
            self._missing += 1
            return False
        self._missing = 0
        clipping = self._clipping
        if acceleration_m_s2 == self._last:
            self._same += 1
            if not clipping.low < acceleration_m_s2 < clipping.high:
                return False
            clipping.see(acceleration_m_s2)
            return False  # a value held over is no new sample
        self._same = 0
        self._last = acceleration_m_s2
        clipping.see(acceleration_m_s2)
        inside = clipping.low < acceleration_m_s2 < clipping.high
        if inside and not (clipping.found and clipping.near(expected_m_s2, self._likely_cut_m_s2())):
            if self._cut:
                self._cut -= 1
            return True
        self._cut = min(self._assumed.stuck_cycles, self._cut + 2)
        return False

    def _likely_cut_m_s2(self) -> float:
        """How near to a limit a sample is likely to be cut off, m/s^2."""
        return self._assumed.likely_cut * sqrt(self.variance) / self._m_per_m_s2

    def bounded(self, residual_m: float, allowed_m: float) -> float:
        """A residual bounded as Huber has it, allowing for allowed_m of vibration; learns the variance from it."""
        assumed, variance = self._assumed, self.variance
        limit = assumed.huber * sqrt(variance)
        short = _within(residual_m, limit)
        variance += (short * short - variance) / assumed.noise_cycles
        self.variance = self._least if self._least > variance else variance
        kept = _within(residual_m, limit + allowed_m)
        self._spikes += ((0.0 if kept == residual_m else 1.0) - self._spikes) / assumed.spikes_cycles
        return kept

    def scatter(self, residual_m: float) -> float:
        """A residual as it counts in its block's scatter: wider than `bounded`, so that sudden noise shows at once."""
        return _within(residual_m, self._assumed.scatter * sqrt(self.variance))

    def compare(self, value_m: float, expected_m: float, variance: float) -> float:
        """Process a block's mean, without bias, and the value that images predict for it; variance: of their
        difference, m^2.

        Returns the growth of the bias's variance, m^2: zero unless the bias has drifted.
        """
        against = self._against
        against.see(value_m, expected_m, variance)
        off = abs(against.gain - 1.0)
        if self.mute:
            self.mute = off > self._images.gain_right or against.gain_std > self._images.gain_known
        else:
            self.mute = off > max(self._images.gain_off, self._images.gain_stds * against.gain_std)
        self._drift *= self._images.drift_kept
        self._drifting *= self._images.drift_told
        if abs(against.offset) < self._images.drifted_stds * against.offset_std:
            return self._images.drift_goes_on * self._drift
        self._drift, self._drifting = against.offset**2, 1.0
        against.forget_offset()
        return self._drift

    @property
    def agrees(self) -> bool:
        """Whether it is known to show the vibration as images do."""
        return not self.mute and self._against.gain_std < self._images.sees_gain_std

    def begin_comparison(self) -> None:
        """What the images made of it was wrong."""
        self._against = AgainstImages(self._all_assumed)
        self._drift = self._drifting = 0.0
        self.mute = False

    @property
    def doubt(self) -> float:
        """Factor for a block's variance: 1, or more as the sensor contradicts the images."""
        strain = self._against.strain
        return strain if strain > self._images.strained else 1.0

    @property
    def sees_impacts(self) -> bool:
        """Whether an impact would show in it: alive, in accord with the images, and its noise small enough."""
        return self.agrees and self.doubt == 1.0

    def alarm(self, time_s: float, excess: float) -> bool:
        """The accelerometer reports an impact, by `excess` times what is significant; whether to believe it.

        No alarm counts if the sensor contradicts the images as much anyway, or if it reports more impacts than any arm
        suffers.
        """
        since = time_s - self._alarm_s
        self._alarms = 1.0 + self._alarms * max(0.0, 1.0 - since / self._images.alarms_s)
        self._alarm_s = time_s
        strain = self._against.strain
        contradicts = strain > self._images.strained or self._images.tense < strain > excess
        return not contradicts and self._alarms < self._images.most_alarms

    @property
    def reason(self) -> str:  # noqa: PLR0911 - one for each fault, in order
        """What is wrong with the sensor, the gravest first; empty for nothing."""
        assumed = self._assumed
        if self._missing > assumed.stuck_cycles:
            return "accelerometer silent"
        if self._same > assumed.stuck_cycles:
            return "accelerometer stuck"
        if self.mute:
            return "accelerometer does not show the vibration"
        if self._cut >= assumed.stuck_cycles // 2:
            return "accelerometer clipped"
        if self._against.strain > self._images.strained:
            return "accelerometer contradicts the images"
        if self._drifting > 0.5:
            return "accelerometer's bias drifts"
        if self._spikes > assumed.spiking:
            return "accelerometer spiking"
        if self.variance > assumed.noisy * self._stated:
            return "accelerometer noisy"
        return ""


def _within(value: float, limit: float) -> float:
    """The number nearest to `value` that is at most `limit` from zero."""
    return limit if value > limit else -limit if value < -limit else value
