"""The energy test: does the joint take energy out of the vibration, or does it feed it?

With q'' + 2 zeta w q' + w^2 q = - p L theta'', the joint's work on the mode per unit of modal mass is, over whole
periods,

    W = - integral p L theta'' q' dt = integral p L theta' q'' dt

and the tip's acceleration may replace q'': its other parts are in quadrature with theta' or not at the mode's
frequency. The mean of p L theta' s'' therefore shows, without any delay or prediction, whether the damping damps (W <
0). Both signals are demodulated at the mode's frequency and averaged over a period. An impact adds energy without work
of the joint. The test fails only if the joint has supplied half of the present energy for a period and a half without
interruption.

Without an accelerometer, or if the drive's direction or the model's sign is wrong, only growth remains: of the
estimated amplitude, and of the accelerometer's amplitude at the mode's frequency, since an estimate from a wrong model
may not grow as the vibration does. An amplitude grows if it rises by a fifth in each of four or more consecutive
periods, to three and a half times its value before them, and to twice the largest of the last minute. The sum counts
more than each period, because an estimate from a wrong model swings by 15 %. No impact causes such a rise. The
accelerometer's amplitude shows an impact in two periods (accelerometer_amplitude.py), and two impacts in four: it has
to rise in five. Twenty simulated hours each of white disturbance and of random impacts (every 0.5, 1, 3 s), at damping
ratios of 0.02, 0.05 and 0.13, gave 12 false alarms by the estimate in 240 hours and 4 by the accelerometer.
"""

from cmath import exp as cexp
from math import exp, isfinite, pi, sqrt

from stillarm.common.files.model import Model
from stillarm.controller.safety.accelerometer_amplitude import LEAST_AMPLITUDE_M, AccelerometerAmplitude

_STRETCH_PERIODS = 1.5  # of uninterrupted work before the test may fail
_SHARE = 0.5  # of the present energy that the joint must have supplied
# Consecutive periods, factor in each, factor over all of them, factor over the largest of the last minute. The false
# alarms with these values are counted above.
_RISES, _RISE, _IN_ALL, _OVER_RECENT = 4, 1.2, 3.5, 2.0
_ACCELEROMETER_RISES = _RISES + 1
_RECENT_S = 60.0
_MEAN_S = 1.0


class EnergyTest:
    """Watches the work of the damping on the first mode, and its amplitude."""

    def __init__(self, model: Model, length_m: float) -> None:
        """Use the model's first mode, accelerometer and cycle."""
        mode, cycle_s, accelerometer = model.arm.modes[0], model.timing.cycle_s, model.accelerometer
        w = mode.angular_frequency
        self._w, self._cycle_s = w, cycle_s
        self._work_per_product = 0.5 * mode.participation * length_m / accelerometer.scale
        self._energy_per_square = 0.5 / (w * accelerometer.scale) ** 2
        self._turn = cexp(complex(0.0, -w * cycle_s))
        period = 2.0 * pi / w
        self._gain = 1.0 - exp(-cycle_s / period)
        self._mean_gain = cycle_s / _MEAN_S
        # of the averaged acceleration's amplitude
        noise = accelerometer.noise_std_m_s2 * sqrt(2.0 * self._gain)
        least = max(abs(accelerometer.scale) * w * w * LEAST_AMPLITUDE_M, 5.0 * noise)
        self._least_energy = least * least * self._energy_per_square
        self._stretch = _STRETCH_PERIODS * period
        self._growth = GrowthTest(period)
        self._accelerometer_amplitude = AccelerometerAmplitude(model)
        self._accelerometer_growth = GrowthTest(
            period, _ACCELEROMETER_RISES, self._accelerometer_amplitude.least_m
        )
        self._unit = 1.0 + 0.0j
        self._velocity = self._acceleration = 0.0j
        self._mean: float | None = None
        self._work = self._since_s = 0.0

    def grows(
        self,
        elapsed: int,
        acceleration_m_s2: float,
        damping_velocity_rad_s: float,
        acting: bool,
        amplitude_m: float,
    ) -> bool:
        """Process a cycle. Returns True if the damping feeds the vibration.

        damping_velocity_rad_s: the joint's measured velocity minus the external reference.
        acting: whether the damping is fully faded in and alone moves the joint. amplitude_m: the estimated amplitude.
        """
        passed = elapsed * self._cycle_s
        grows = self._growth.grows(passed, amplitude_m, acting)
        if isfinite(acceleration_m_s2):
            fed = self._fed(elapsed, acceleration_m_s2, damping_velocity_rad_s, acting)
            grows = (
                self._accelerometer_growth.grows(passed, self._accelerometer_amplitude.amplitude_m, acting)
                or fed
                or grows
            )
        return grows

    def _fed(self, elapsed: int, acceleration_m_s2: float, velocity_rad_s: float, acting: bool) -> bool:
        mean = acceleration_m_s2 if self._mean is None else self._mean
        self._mean = mean + self._mean_gain * (acceleration_m_s2 - mean)
        unit = self._unit * (self._turn if elapsed == 1 else self._turn**elapsed)
        # keeps the modulus at 1
        self._unit = unit * (1.5 - 0.5 * (unit.real * unit.real + unit.imag * unit.imag))
        gain = self._gain
        self._velocity += gain * (velocity_rad_s * unit - self._velocity)
        turned = (acceleration_m_s2 - mean) * unit
        self._acceleration += gain * (turned - self._acceleration)
        self._accelerometer_amplitude.add(elapsed, turned)
        a, v = 2.0 * self._acceleration, 2.0 * self._velocity
        power = self._work_per_product * (v.real * a.real + v.imag * a.imag)
        if not acting or power <= 0.0:
            self._work = self._since_s = 0.0
            return False
        passed = elapsed * self._cycle_s
        self._work += power * passed
        self._since_s += passed
        energy = (a.real * a.real + a.imag * a.imag) * self._energy_per_square
        return self._since_s > self._stretch and energy > self._least_energy and self._work > _SHARE * energy

    def restart(self) -> None:
        """Forget the past, after the state was cleared."""
        self._work = self._since_s = 0.0
        self._growth.restart()
        self._accelerometer_growth.restart()


class GrowthTest:
    """Distinguishes steady growth of an amplitude from impacts, by its greatest value in each period."""

    def __init__(
        self, period_s: float, rises: int = _RISES, least_amplitude_m: float = LEAST_AMPLITUDE_M
    ) -> None:
        """For an oscillation of that period. rises: required consecutive rises, each above the least amplitude."""
        self._every_s, self._least_rises, self._least_m = period_s, rises, least_amplitude_m
        self._keep = exp(-period_s / _RECENT_S)
        self.restart()

    def restart(self) -> None:
        """Forget the past."""
        self._passed_s = self._last_m = self._recent_m = self._greatest_m = self._before_m = 0.0
        self._rises = 0

    def grows(self, passed_s: float, amplitude_m: float, acting: bool) -> bool:
        """Process the amplitude. Returns True if it has grown steadily while the damping acted."""
        if not isfinite(amplitude_m):
            return False
        if amplitude_m > self._greatest_m:  # noqa: PLR1730 - max() would cost a call in every cycle
            self._greatest_m = amplitude_m
        self._passed_s += passed_s
        if self._passed_s < self._every_s:
            return False
        self._passed_s = 0.0
        greatest, self._greatest_m = self._greatest_m, 0.0
        rising = acting and greatest > _RISE * self._last_m and greatest > self._least_m
        if rising and not self._rises:
            self._before_m = self._last_m
        self._last_m = greatest
        if not rising:
            self._rises = 0
            self._recent_m = max(greatest, self._recent_m * self._keep)
            return False
        self._rises += 1
        risen = greatest > max(_IN_ALL * self._before_m, _OVER_RECENT * self._recent_m)
        return self._rises >= self._least_rises and risen
