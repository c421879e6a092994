"""What the joint's known acceleration adds to each mode's phasor, summed up, with the last second of it."""

from cmath import exp
from math import ceil

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

_HELD = 1024  # cycles


class JointInput:
    """Sum G of the phasor increments -i (dv / w) exp(-i w t), dv = - participation length theta'' dt, per mode.

    Between two instants an undamped, correctly tuned phasor moves by the difference of G; docs/fused.md, section 1.
    """

    def __init__(self, w: list[float], gain: list[float], cycle_s: float) -> None:
        """w: damped angular frequency of each mode, rad/s; gain: - participation length / w."""
        self._cycle_s = cycle_s
        self._w = w
        self._gain = [-1j * g * cycle_s for g in gain]
        self._half_back = [exp(0.5j * one * cycle_s) for one in w]
        self._held = np.zeros((_HELD, len(w)), dtype=np.complex128)
        self._position = np.zeros(_HELD)
        self._cycle: int | None = None
        self.sum = [0j] * len(w)
        self.increment = [0j] * len(w)

    def advance(
        self, cycle: int, turn: list[complex], mean_acceleration_rad_s2: float, position_rad: float
    ) -> None:
        """Move on to `cycle`, where exp(i w t) is `turn`; the mean of theta'' over the cycle before."""
        skipped = 0 if self._cycle is None else min(cycle - self._cycle - 1, _HELD)
        self._cycle = cycle
        for back in range(skipped, -1, -1):
            self._position[(cycle - back) % _HELD] = position_rad
        for i, one in enumerate(turn):
            step = self._gain[i] * mean_acceleration_rad_s2 * one.conjugate() * self._half_back[i]
            for back in range(skipped, 0, -1):  # cycles that never came: the same load at their own phase
                self.sum[i] += step * exp(1j * self._w[i] * back * self._cycle_s)
                self._held[(cycle - back) % _HELD, i] = self.sum[i]
            self.sum[i] += step
            self.increment[i] = step
            self._held[cycle % _HELD, i] = self.sum[i]

    def add(self, time_s: float, increment: list[complex]) -> None:
        """A strike at time_s, within the last second, has moved the phasors by `increment`."""
        newest = 0 if self._cycle is None else self._cycle
        first = ceil(time_s / self._cycle_s)
        for i, more in enumerate(increment):
            self.sum[i] += more
            for cycle in range(max(first, newest - _HELD + 1), newest + 1):
                self._held[cycle % _HELD, i] += more

    def position_at(self, time_s: float) -> float:
        """theta at an instant of the last second, rad."""
        return float(self.positions_at(np.array((time_s,)))[0])

    def positions_at(self, times_s: Array) -> Array:
        """theta at instants of the last second, rad; shape as times_s."""
        low, fraction = self._places(times_s)
        before = self._position.take(low, mode="wrap")
        result: Array = before + fraction * (self._position.take(low + 1, mode="wrap") - before)
        return result

    def seen_from(self, edge_s: float, times_s: Array, slope_s: float) -> tuple[Array, Array, ComplexArray]:
        """At k instants of the last second: theta, theta' over twice slope_s, and what G has grown by since edge_s.

        Shapes (k,), (k,), (k, m).
        """
        k = len(times_s)
        asked = np.empty(3 * k + 1)
        asked[:k], asked[k] = times_s, edge_s
        asked[k + 1 : 2 * k + 1], asked[2 * k + 1 :] = times_s + slope_s, times_s - slope_s
        low, fraction = self._places(asked)
        after = low + 1
        before = self._position.take(low, mode="wrap")
        theta = before + fraction * (self._position.take(after, mode="wrap") - before)
        held = self._held.take(low[: k + 1], axis=0, mode="wrap")
        sums = held + fraction[: k + 1, None] * (self._held.take(after[: k + 1], axis=0, mode="wrap") - held)
        rate = (theta[k + 1 : 2 * k + 1] - theta[2 * k + 1 :]) * (0.5 / slope_s)
        return theta[:k], rate, sums[:k] - sums[k]

    def _places(self, times_s: Array) -> tuple[NDArray[np.int64], Array]:
        newest = 0 if self._cycle is None else self._cycle
        places = np.minimum(
            np.maximum(times_s / self._cycle_s, max(newest - _HELD + 2.0, 0.0)), newest - 1e-9
        )
        low = places.astype(np.int64)
        return low, places - low
