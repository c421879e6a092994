"""The capture delay by recursive cross-correlation of the image with the accelerometer: eq. 2 to 11 of the paper.

Where the paper leaves points open or is biased, this module does the following (docs/methods.md gives the reasons):

- The vibration x from the accelerometer is correlated with the deflection y from the image at the instants of arrival
  only. An image held until the next one would look half a frame too late.
- Mean and power are updated with the product at each lag, so that the maximised quantity is the correlation
  coefficient r(m). By the Cauchy-Schwarz inequality its maximum lies at the true delay for every window and offset.
- The force of an impact is not vibration, and is much larger while it lasts. Its samples are left out
  (impact_samples.py).
- x is averaged over 2 J + 1 cycles, a pure delay of J, so that all of the accelerometer's samples count, not just those
  at arrivals.
- Lags are searched within less than half a period of the prior, never at both ends of a periodic function. Each image
  is kept for a moment before it is correlated, so that short delays also have lags on both sides.
- The maximum is that of a cosine of the mode's frequency, fitted to r around its peak.
- The acceleration leads the deflection by 2 zeta / w, and its filter delays it; both are compensated.
"""

from collections import deque
from math import atan2, ceil, exp, floor, hypot, isfinite, nan, sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import Correlation
from stillarm.common.files.model import Model
from stillarm.controller.estimation.delay.impact_samples import ImpactSamples
from stillarm.controller.estimation.delay.moving_average import MovingAverage
from stillarm.controller.estimation.estimate import DelayEstimate, Status
from stillarm.controller.joint.history import CycleHistory

_HOLD_TIME_S = 5.0  # s: an unobserved delay's uncertainty grows back to its prior spread in about this time
_LEAST_SPREAD_S = 0.005  # s: lower bound of the delay's spread, whatever the model states


class RecursiveCorrelation:
    """Eq. 11 with its means and powers: the correlation coefficient of x at several lags with y, with forgetting."""

    def __init__(self, lags: int) -> None:
        """No sample yet."""
        self._weight = 0.0
        self._x, self._xx, self._xy = np.zeros(lags), np.zeros(lags), np.zeros(lags)
        self._y = self._yy = 0.0
        self._power = self._power_squared = 0.0

    def add(self, x: NDArray[np.float64], y: float, gain: float) -> None:
        """Process y with x at each lag, (lags,), at the weight `gain` against all that was seen before."""
        self._weight += gain * (1.0 - self._weight)
        self._x += gain * (x - self._x)
        self._xx += gain * (x * x - self._xx)
        self._xy += gain * (x * y - self._xy)
        self._y += gain * (y - self._y)
        self._yy += gain * (y * y - self._yy)
        share = gain * (y - self._y / self._weight) ** 2
        self._power += share - gain * self._power
        self._power_squared += share * share - gain * (2.0 - gain) * self._power_squared

    @property
    def variance_y(self) -> float:
        """Of y about its mean, in its unit squared."""
        w = self._weight
        return self._yy / w - (self._y / w) ** 2

    def observed(self, elapsed: float) -> float:
        """Time in which equally strong samples of y would tell as much, if one came every `elapsed`."""
        return elapsed * self._power**2 / max(self._power_squared, 1e-300)

    def coefficients(self) -> NDArray[np.float64]:
        """The correlation coefficient at each lag, (lags,)."""
        w = self._weight
        variance_x = self._xx / w - (self._x / w) ** 2
        covariance = self._xy / w - self._x * (self._y / (w * w))
        result: NDArray[np.float64] = covariance / np.sqrt(np.maximum(variance_x * self.variance_y, 1e-30))
        return result


class CorrelationDelay:
    """The delay at the peak of the correlation: recursive, normalised, with forgetting."""

    def __init__(self, model: Model, settings: Correlation) -> None:
        """Search around model.timing.capture_delay_s for the first mode of the model."""
        mode, cycle_s = model.arm.modes[0], model.timing.cycle_s
        period = 1.0 / mode.frequency_hz / cycle_s
        prior = model.timing.capture_delay_s / cycle_s
        self._cycle_s = cycle_s
        self._settings = settings
        self._angle_per_cycle = mode.angular_frequency * cycle_s
        self._prior_spread_s = max(model.timing.capture_delay_std_s, _LEAST_SPREAD_S)
        self._half_width = max(1, round(period / 12.0))
        # difference between a lag of the averaged x and the delay: of the average, of the filter, and the lead
        self._shift_s = (
            self._half_width * cycle_s
            + model.accelerometer.delay_s
            - 2.0 * mode.damping_ratio / mode.angular_frequency
        )
        shift, search = self._shift_s / cycle_s, settings.search_periods * period
        self._peak_reach = reach = max(3, round(period / 16.0))
        self._first = floor(max(0.0, prior - search) - shift) - reach
        self._last = ceil(prior + search - shift) + reach
        self._wait = max(0, -self._first)  # until the accelerometer's samples of all lags are available
        self._waiting: deque[tuple[int, float]] = deque()
        self._average = MovingAverage(2 * self._half_width + 1)
        sensor = model.accelerometer
        self._impacts = ImpactSamples(
            sensor.noise_std_m_s2 / abs(sensor.scale) / mode.angular_frequency**2,
            self._half_width,
            self._angle_per_cycle,
        )
        self._remembered = self._wait + self._last + 64
        self._smooth = CycleHistory(self._remembered)
        self._cycle: int | None = None
        self._window = settings.window_s / cycle_s
        count = self._last - self._first + 1
        self._sums = RecursiveCorrelation(count)
        self._half_period = 0.5 * period
        self._noise_m = (
            model.accelerometer.noise_std_m_s2
            / abs(model.accelerometer.scale)
            / mode.angular_frequency**2
            / sqrt(2 * self._half_width + 1)
        )
        angles = self._angle_per_cycle * np.arange(-reach, reach + 1)
        self._to_quadratures = np.linalg.pinv(np.column_stack((np.cos(angles), np.sin(angles))))
        self._arrival: int | None = None
        self.correlation = np.zeros(count)
        self.estimate = DelayEstimate(model.timing.capture_delay_s, self._prior_spread_s, Status.UNESTIMATED)

    @property
    def lags_s(self) -> NDArray[np.float64]:
        """The capture delay of each element of `correlation`, s."""
        lags: NDArray[np.float64] = np.arange(self._first, self._last + 1, dtype=np.float64)
        return lags * self._cycle_s + self._shift_s

    def see_cycle(self, cycle: int, vibration: float) -> None:
        """Process the accelerometer's vibration in a cycle, m; NaN without a sample.

        A missing cycle (an overrun; a recording at a lower rate) counts as a cycle without a sample.
        """
        if self._cycle is not None and cycle - self._cycle > 1:
            self._miss(self._cycle + 1, cycle - 1)
        self._cycle = cycle
        mean = self._average.add(self._impacts.without(vibration))
        self._impacts.see_average(mean)
        self._smooth.write(cycle, mean)
        while self._waiting and self._waiting[0][0] <= cycle - self._wait:
            arrival, deflection = self._waiting.popleft()
            self._correlate(arrival, deflection, cycle - arrival)

    def _miss(self, first: int, last: int) -> None:
        """Process cycles without a sample. Once the average contains none, it stays unchanged."""
        needed = 2 * self._half_width + 1
        for missed in range(first, min(last, first + needed) + 1):
            self._smooth.write(missed, self._average.add(nan))
        self._smooth.fill(last, self._average.mean)

    def see_sample(self, sample: VisualSample, cycle: int, deflection_m: float) -> None:
        """Process the deflection of an image that was read in `cycle`."""
        if isfinite(deflection_m):
            self._waiting.append((cycle, deflection_m))

    def _correlate(self, arrival: int, deflection_m: float, age: int) -> None:
        """Eq. 11 for all lags at once, for an image that arrived `age` cycles ago."""
        elapsed = 1.0 if self._arrival is None else max(1.0, min(arrival - self._arrival, self._window))
        self._arrival = arrival
        rho = self._settings.forgetting
        gain = rho * elapsed / ((1.0 - rho) * (self._window - elapsed) + rho * elapsed)
        x = self._smooth.lags(age + self._first, age + self._last)[::-1]
        self._sums.add(x, deflection_m, gain)
        self.correlation = self._sums.coefficients()
        measured = self._measured(elapsed)
        if measured is None:
            self._hold(elapsed * self._cycle_s)
        else:
            self.estimate = measured

    def _measured(self, elapsed: float) -> DelayEstimate | None:
        """The delay at the peak; None where there is none to trust, or the held delay is better."""
        amplitude = sqrt(max(0.0, 2.0 * self._sums.variance_y))
        seen = self._sums.observed(elapsed)
        if amplitude < self._settings.min_amplitude_m or seen < self._half_period:
            return None
        peak = self._peak()
        if peak is None:
            return None
        lag, height = peak
        delay = lag * self._cycle_s + self._shift_s
        std = self._std_s(min(height, 1.0), amplitude, seen)
        known = self.estimate.status is not Status.UNESTIMATED
        if known and std > self._held_std_s(elapsed * self._cycle_s):
            return None
        return DelayEstimate(max(0.0, delay), std, Status.ESTIMATED)

    def _peak(self) -> tuple[float, float] | None:
        """Lag, in cycles, and height of a cosine fitted around the largest coefficient; None for no peak."""
        reach = self._peak_reach
        largest = int(np.argmax(self.correlation))
        if not reach <= largest < len(self.correlation) - reach:
            return None
        cosine, sine = self._to_quadratures @ self.correlation[largest - reach : largest + reach + 1]
        offset = atan2(sine, cosine) / self._angle_per_cycle
        height = hypot(cosine, sine)
        if height < self._settings.min_correlation or abs(offset) > reach or not isfinite(offset):
            return None
        return self._first + largest + offset, height

    def _std_s(self, height: float, amplitude_m: float, seen: float) -> float:
        """Standard deviation of the delay from the phase of two sinusoids: sqrt(noise / signal / independent samples) /
        w.

        Noise: from the height of the peak, at least the accelerometer's own after averaging. Independent samples: one
        for each length of the moving average in the effectively observed cycles.
        """
        independent = max(1.0, seen / (2 * self._half_width + 1))
        noise_to_signal = max(1.0 / (height * height) - 1.0, 2.0 * (self._noise_m / amplitude_m) ** 2)
        return sqrt(noise_to_signal / independent) * self._cycle_s / self._angle_per_cycle

    def _hold(self, elapsed_s: float) -> None:
        """The delay is not observable: keep it, and let its uncertainty grow back to the prior spread."""
        if self.estimate.status is not Status.UNESTIMATED:
            self.estimate = DelayEstimate(self.estimate.delay_s, self._held_std_s(elapsed_s), Status.HELD)

    def _held_std_s(self, elapsed_s: float) -> float:
        std, prior = self.estimate.std_s, self._prior_spread_s
        keep = exp(-2.0 * elapsed_s / _HOLD_TIME_S)
        return max(std, sqrt(std * std * keep + prior * prior * (1.0 - keep)))
