"""Which samples of the accelerometer are good, how noisy they are, and whether it is alive."""

from math import isfinite, sqrt

_STUCK_CYCLES = 30
_CLIPPED = 0.98  # of the range
_HUBER = 4.0
_MEMORY_CYCLES = 700.0
_GAIN_MEMORY_BLOCKS = 80.0


class AccelerometerHealth:
    """Sorts out missing, clipped and stuck samples, bounds spikes, learns the noise, sees a dead sensor."""

    def __init__(self, noise_m: float, range_m_s2: float, least_m: float) -> None:
        """noise_m: standard deviation of a sample as deflection, m, as the model has it; least_m: a floor to it."""
        self.variance = max(noise_m, least_m) ** 2
        self._least = least_m**2
        self._limit = _CLIPPED * range_m_s2
        self._last = float("nan")
        self._same = 0
        self._missing = 0
        self._seen_power = self._seen_product = 0.0
        self._noise_power = 0.0
        self.mute = False
        self.reason = ""

    def usable(self, acceleration_m_s2: float) -> bool:
        """Whether a raw sample may be used at all."""
        if not isfinite(acceleration_m_s2):
            self._missing += 1
            if self._missing > _STUCK_CYCLES:
                self.reason = "accelerometer silent"
            return False
        self._missing = 0
        if acceleration_m_s2 == self._last:
            self._same += 1
            if self._same > _STUCK_CYCLES:
                self.reason = "accelerometer stuck"
                return False
        else:
            self._same = 0
            self._last = acceleration_m_s2
        if abs(acceleration_m_s2) >= self._limit:
            self.reason = "accelerometer clipped"
            return False
        if self.mute:
            self.reason = "accelerometer does not show the vibration"
            return True
        self.reason = ""
        return True

    def bounded(self, residual_m: float) -> float:
        """A residual bounded as Huber has it; learns the variance from it."""
        limit = _HUBER * sqrt(self.variance)
        kept = min(max(residual_m, -limit), limit)
        self.variance += (kept * kept - self.variance) / _MEMORY_CYCLES
        self.variance = max(self.variance, self._least)
        return kept

    def compare(self, value_m: float, expected_m: float, variance: float) -> None:
        """A block's mean (without bias) against what the fused vibration says: a gain near zero is a dead sensor."""
        keep = 1.0 - 1.0 / _GAIN_MEMORY_BLOCKS
        self._seen_power = keep * self._seen_power + expected_m * expected_m
        self._seen_product = keep * self._seen_product + value_m * expected_m
        self._noise_power = keep * self._noise_power + variance * expected_m * expected_m
        if self._seen_power <= 0.0:
            return
        gain = self._seen_product / self._seen_power
        std = sqrt(self._noise_power) / self._seen_power
        if std > 0.08:
            return
        self.mute = not (0.5 < gain < 2.0) if not self.mute else not (0.7 < gain < 1.4)
