"""Which samples of the accelerometer are good, how much they count, and whether it is alive.

Radiation makes a sensor noisy, lets it drift, clip, spike, stick, or die. Each is recognised by a test of its own;
`reason` names the gravest one found.
"""

from math import isfinite, sqrt

from stillarm.controller.estimation.fused.against_images import AgainstImages
from stillarm.controller.estimation.fused.clipping import Clipping

_STUCK_CYCLES = 30
_CLIPPED = 0.98  # of the range
_LIKELY_CUT = 2.0  # standard deviations from a limit
_HUBER, _SCATTER = 4.0, 12.0
_MEMORY_CYCLES = 700.0
_NOISY = 4.0  # times the variance that the model states
_SPIKING, _SPIKES_MEMORY = 0.01, 1000.0  # share of samples beyond the bound; cycles
_GAIN_OFF, _GAIN_RIGHT, _GAIN_KNOWN = 0.3, 0.2, 0.1
_GAIN_STDS = 3.5
_SEES = 0.15  # standard deviation of the gain over a period
_DRIFTED_STDS = 5.0
_DRIFT_KEPT, _DRIFT_GOES_ON, _DRIFT_TOLD = 0.985, 0.1, 0.994  # in each block after it
_STRAINED = 2.5  # mean normalised difference from the images squared
_TENSE = 1.5  # likewise: by chance in one block of forty
_ALARMS_MEMORY_S, _MOST_ALARMS = 1.0, 4.0


class AccelerometerHealth:
    """Sorts out missing, stuck and clipped samples, bounds spikes, learns the noise, sees a dead sensor.

    variance: of a sample as deflection, m^2. mute: not to be used. reason: what is wrong with it, "" for nothing.
    """

    def __init__(self, noise_m: float, range_m_s2: float, least_m: float, m_per_m_s2: float) -> None:
        """noise_m: standard deviation of a sample as deflection, m, as the model has it; least_m: a floor to it.

        m_per_m_s2: deflection that an acceleration of 1 m/s^2 stands for.
        """
        self.variance = max(noise_m, least_m) ** 2
        self._stated = self.variance
        self._least = least_m**2
        self._m_per_m_s2 = m_per_m_s2
        self._clipping = Clipping(_CLIPPED * range_m_s2)
        self._against = AgainstImages()
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
        margin = _LIKELY_CUT * sqrt(self.variance) / self._m_per_m_s2
        inside = clipping.low < acceleration_m_s2 < clipping.high
        if inside and (not clipping.found or not clipping.near(expected_m_s2, margin)):
            self._cut = max(0, self._cut - 1)
            return True
        self._cut = min(_STUCK_CYCLES, self._cut + 2)
        return False

    def bounded(self, residual_m: float, allowed_m: float) -> float:
        """A residual bounded as Huber has it, allowing for allowed_m of vibration; learns the variance from it."""
        limit = _HUBER * sqrt(self.variance)
        short = min(max(residual_m, -limit), limit)
        self.variance += (short * short - self.variance) / _MEMORY_CYCLES
        kept = min(max(residual_m, -limit - allowed_m), limit + allowed_m)
        self.variance = max(self.variance, self._least)
        self._spikes += (float(kept != residual_m) - self._spikes) / _SPIKES_MEMORY
        return kept

    def scatter(self, residual_m: float) -> float:
        """A residual as it counts in its block's scatter: wider than `bounded`, so that sudden noise shows at once."""
        limit = _SCATTER * sqrt(self.variance)
        return min(max(residual_m, -limit), limit)

    def compare(self, value_m: float, expected_m: float, variance: float) -> float:
        """A block's mean, without bias, against what images say of its time; variance: of the difference, m^2.

        Returns by how much, m^2, the bias has become uncertain: zero unless it has drifted away.
        """
        against = self._against
        against.see(value_m, expected_m, variance)
        off = abs(against.gain - 1.0)
        if self.mute:
            self.mute = off > _GAIN_RIGHT or against.gain_std > _GAIN_KNOWN
        else:
            self.mute = off > max(_GAIN_OFF, _GAIN_STDS * against.gain_std)
        self._drift *= _DRIFT_KEPT
        self._drifting *= _DRIFT_TOLD
        if abs(against.offset) < _DRIFTED_STDS * against.offset_std:
            return _DRIFT_GOES_ON * self._drift
        self._drift, self._drifting = against.offset**2, 1.0
        against.forget_offset()
        return self._drift

    def begin_comparison(self) -> None:
        """What the images made of it was wrong."""
        self._against = AgainstImages()
        self._drift = self._drifting = 0.0
        self.mute = False

    @property
    def doubt(self) -> float:
        """By what a block's variance is to be multiplied: 1, or how far the sensor contradicts the images."""
        strain = self._against.strain
        return strain if strain > _STRAINED else 1.0

    @property
    def sees_impacts(self) -> bool:
        """Whether an impact would show in it: alive, in accord with the images, and its noise small enough."""
        return not self.mute and self.doubt == 1.0 and self._against.gain_std < _SEES

    def alarm(self, time_s: float, excess: float) -> bool:
        """The accelerometer reports an impact, by `excess` times what is significant; whether to believe it.

        Not where it contradicts the images as much anyway, nor when it reports more of them than any arm is struck.
        """
        since = time_s - self._alarm_s
        self._alarms = 1.0 + self._alarms * max(0.0, 1.0 - since / _ALARMS_MEMORY_S)
        self._alarm_s = time_s
        strain = self._against.strain
        contradicts = strain > _STRAINED or _TENSE < strain > excess
        return not contradicts and self._alarms < _MOST_ALARMS

    @property
    def reason(self) -> str:
        """What is wrong with the sensor, the gravest first; empty for nothing."""
        for there, name in (
            (self._missing > _STUCK_CYCLES, "accelerometer silent"),
            (self._same > _STUCK_CYCLES, "accelerometer stuck"),
            (self.mute, "accelerometer does not show the vibration"),
            (self._cut >= _STUCK_CYCLES // 2, "accelerometer clipped"),
            (self._against.strain > _STRAINED, "accelerometer contradicts the images"),
            (self._drifting > 0.5, "accelerometer's bias drifts"),
            (self._spikes > _SPIKING, "accelerometer spiking"),
            (self.variance > _NOISY * self._stated, "accelerometer noisy"),
        ):
            if there:
                return name
        return ""
