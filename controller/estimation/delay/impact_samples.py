"""Detects accelerometer samples that contain the force of an impact, to leave them out of a correlation.

Two earlier averages predict a vibration of known frequency. A few samples far from that prediction are a force. If they
were kept, impacts that always come at the same side of the vibration would bias the delay, by 0.8 ms in the benchmark.
"""

from collections import deque
from math import isfinite, nan, pi, sin

_STDS, _OF_AMPLITUDE = 4.0, 0.5  # tolerance: deviations of the noise, plus a fraction of the amplitude
_SIZE_MEMORY_CYCLES = 1000.0  # time constant of the mean amplitude
_MOST_RUNNING = 40  # cycles: a longer deviation is not an impact


class ImpactSamples:
    """Recognises an impact's samples by their distance from the prediction of the last averages."""

    def __init__(self, noise_m: float, half_width: int, angle_per_cycle: float) -> None:
        """noise_m: of a sample, as deflection; averages are over 2 half_width + 1 cycles, half_width cycles old."""
        near = half_width * angle_per_cycle
        far = 3.0 * near
        self._near, self._far = sin(far) / sin(far - near), -sin(near) / sin(far - near)
        self._noise_m = noise_m
        self._needed = 2 * half_width + 1
        self._averages: deque[float] = deque(maxlen=self._needed)
        self._size = 0.0
        self._running = 0

    def see_average(self, mean_m: float) -> None:
        """Add the present moving average."""
        self._averages.append(mean_m)

    def without(self, vibration_m: float) -> float:
        """The sample, or NaN if it belongs to an impact."""
        averages = self._averages
        if len(averages) < self._needed or not isfinite(vibration_m):
            return vibration_m
        expected = self._near * averages[-1] + self._far * averages[0]
        self._size += (0.5 * pi * abs(expected) - self._size) / _SIZE_MEMORY_CYCLES
        if abs(vibration_m - expected) <= _STDS * self._noise_m + _OF_AMPLITUDE * self._size:
            self._running = 0
            return vibration_m
        self._running += 1
        return nan if self._running <= _MOST_RUNNING else vibration_m
