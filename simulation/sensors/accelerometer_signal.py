"""What the simulated accelerometer makes of the tip's true acceleration, short of quantising it."""

from collections import deque
from math import floor

import numpy as np

from stillarm.common.files.model import Accelerometer
from stillarm.simulation.sensors.accelerometer_effects import AccelerometerEffects

ACCELEROMETER_STREAM = 1  # of the seed's random streams
_BLOCK = 1024  # numbers are cheap to draw by the thousand, and dear one by one


class AccelerometerSignal:
    """clip(scale * s''(t - delay) + bias + white noise, range), sample by sample; effects come before the noise.

    The delay is exact in whole cycles; its fraction is taken by Lagrange's cubic through four samples, with
    an error of order (w cycle)^4: 1e-8 of the amplitude at 2.6 Hz and 1 kHz. Before the first sample the tip
    was at rest. Deterministic from the generator's seed.
    """

    def __init__(
        self,
        accelerometer: Accelerometer,
        cycle_s: float,
        generator: np.random.Generator,
        effects: AccelerometerEffects | None = None,
    ) -> None:
        """cycle_s: the time from one sample to the next. generator: of the noise."""
        self._effects = effects
        self._scale = accelerometer.scale
        self._bias = accelerometer.bias_m_s2
        self._std = accelerometer.noise_std_m_s2
        self._range = accelerometer.range_m_s2
        self._generator = generator
        self._noise: list[float] = []
        cycles = accelerometer.delay_s / cycle_s
        whole = floor(cycles + 1e-9)
        fraction = max(0.0, cycles - whole)
        first = max(0, whole - 1) if fraction > 1e-9 else whole
        self._weights = _lagrange(cycles - first) if fraction > 1e-9 else (1.0,)
        length = first + len(self._weights)
        self._past: deque[float] = deque([0.0] * length, maxlen=length)

    def sample(
        self, tip_acceleration_m_s2: float, effect_time_s: float = 0.0, tip_angle_rad: float = 0.0
    ) -> float:
        """What the sensor gives at this cycle, m/s^2, from the true s'' at this cycle.

        effect_time_s: time from the recording's start. tip_angle_rad: theta plus the slope of the tip. Both
        matter to effects only.
        """
        past = self._past
        past.append(tip_acceleration_m_s2)
        weights = self._weights
        if len(weights) == 1:
            delayed = past[0]
        else:
            delayed = (
                weights[3] * past[0] + weights[2] * past[1] + weights[1] * past[2] + weights[0] * past[3]
            )
        value = self._scale * delayed + self._bias
        if self._effects is not None:
            value = self._scale * self._effects.sensitivity(effect_time_s) * delayed + self._bias
            value += self._effects.added_m_s2(effect_time_s, tip_angle_rad)
        if self._std:
            if not self._noise:
                self._noise = (self._generator.standard_normal(_BLOCK) * self._std)[::-1].tolist()
            value += self._noise.pop()
        limit = self._range
        return limit if value > limit else -limit if value < -limit else value


def _lagrange(position: float) -> tuple[float, float, float, float]:
    """Weights of four samples at 0, 1, 2, 3 for the cubic through them at `position`."""
    a, b, c, d = position, position - 1.0, position - 2.0, position - 3.0
    return -b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0
