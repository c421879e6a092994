"""Which samples of the accelerometer are good, how noisy they are, and whether it is alive."""

from math import isfinite, sqrt

_STUCK_CYCLES = 30
_CLIPPED = 0.98  # of the range
_HUBER = 4.0
_MEMORY_CYCLES = 700.0
_GAIN_MEMORY_BLOCKS = 25.0
_ENOUGH_POWER = 150.0  # a gain known to 0.08
_ALIVE, _ALIVE_AGAIN = (0.5, 2.0), (0.7, 1.4)


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
            return False  # a value held over is no new sample
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

    def bounded(self, residual_m: float, allowed_m: float) -> float:
        """A residual bounded as Huber has it, allowing for allowed_m of vibration; learns the variance from it."""
        limit = _HUBER * sqrt(self.variance)
        short = min(max(residual_m, -limit), limit)
        self.variance += (short * short - self.variance) / _MEMORY_CYCLES
        kept = min(max(residual_m, -limit - allowed_m), limit + allowed_m)
        self.variance = max(self.variance, self._least)
        return kept

    def compare(self, value_m: float, expected_m: float, variance: float) -> None:
        """A block's mean, without bias, against what images say of its time: a gain far from one is a dead sensor.

        variance: of the difference, m^2.
        """
        keep = 1.0 - 1.0 / _GAIN_MEMORY_BLOCKS
        self._seen_power = keep * self._seen_power + expected_m * expected_m / variance
        self._seen_product = keep * self._seen_product + value_m * expected_m / variance
        if self._seen_power < _ENOUGH_POWER:
            return
        gain = self._seen_product / self._seen_power
        low, high = _ALIVE_AGAIN if self.mute else _ALIVE
        self.mute = not low < gain < high
