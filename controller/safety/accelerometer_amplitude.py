"""The vibration's amplitude by the accelerometer, for each half period.

The mean of 2 a exp(-i w t) over half a period is the amplitude of an acceleration a at the frequency w, since the part
at twice that frequency completes a whole period. No shorter mean has that property. It shows an impact partly in the
half period of the impact, and fully in the next one, hence in two periods at the most.
"""

from math import pi, sqrt

from stillarm.common.files.model import Model

LEAST_AMPLITUDE_M = 0.0005
_NOISE_STDS = 5.0  # standard deviations of the amplitude by noise alone


class AccelerometerAmplitude:
    """Amplitude of the model's first mode. amplitude_m: of the last complete half period; 0 before the first one.

    least_m: smallest significant amplitude, above the accelerometer's noise and at least LEAST_AMPLITUDE_M.
    """

    def __init__(self, model: Model) -> None:
        """Use the model's first mode, accelerometer and cycle."""
        w, sensor = model.arm.modes[0].angular_frequency, model.accelerometer
        self._half_period = max(1, round(pi / w / model.timing.cycle_s))  # cycles
        self._metres_per_m_s2 = 1.0 / (w * w * abs(sensor.scale))
        noise_m_s2 = sensor.noise_std_m_s2 * sqrt(2.0 / self._half_period)  # of either quadrature
        self.least_m = max(LEAST_AMPLITUDE_M, _NOISE_STDS * noise_m_s2 * self._metres_per_m_s2)
        self.amplitude_m = 0.0
        self._sum = 0.0j
        self._samples = self._passed = 0

    def add(self, elapsed: int, turned_m_s2: complex) -> None:
        """Add a sample without its mean, times exp(-i w t), `elapsed` cycles after the last one."""
        self._sum += turned_m_s2
        self._samples += 1
        self._passed += elapsed
        if self._passed < self._half_period:
            return
        self.amplitude_m = 2.0 * abs(self._sum) / self._samples * self._metres_per_m_s2
        self._sum, self._samples, self._passed = 0.0j, 0, 0
