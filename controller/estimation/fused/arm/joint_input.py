"""The phasor increments by the joint's known acceleration, summed for each mode, with their last second.

Implements Eqs. 2, 3, 4, 7 of docs/fused.md.
"""

from cmath import exp
from collections import deque
from math import ceil

import numpy as np
from numpy.typing import NDArray

from stillarm.controller.estimation.fused.arm.resting_joint import RestingJoint
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


class JointInput:
    """Sum G of the phasor increments -i (dv / w) exp(-i w t), dv = - participation length theta'' dt, per mode.

    Between two instants an undamped, correctly tuned phasor moves by the difference of G (Eq. 4).
    """

    def __init__(
        self, w: list[float], gain: list[float], cycle_s: float, assumed: Assumptions = ASSUMPTIONS
    ) -> None:
        """w: damped angular frequency of each mode, rad/s; gain: - participation length / w."""
        self._assumed = assumed.joint
        self._cycles = self._assumed.held_cycles
        self._cycle_s = cycle_s
        self._w = w
        self._gain = [-1j * g * cycle_s for g in gain]
        self._half_back = [exp(0.5j * one * cycle_s) for one in w]
        # by cycle: G of each mode, then theta + i theta'
        self._held = np.zeros((self._cycles, len(w) + 1), dtype=np.complex128)
        self._position, self._rate = self._held.real[:, -1], self._held.imag[:, -1]
        self._reach = max(1, round(self._assumed.slope_s / cycle_s))
        self._recent: deque[float] = deque(maxlen=2 * self._reach + 1)
        self._joint = RestingJoint(assumed)
        self._moved_cycle = 0  # when the joint moved last
        self._per_s = 0.5 / (self._reach * cycle_s)
        self._noise = self._noise_count = 0.0
        self._cycle: int | None = None
        self.sum = [0j] * len(w)
        self.increment = [0j] * len(w)

    def advance(
        self, cycle: int, turn: list[complex], mean_acceleration_rad_s2: float, position_rad: float
    ) -> None:
        """Move on to `cycle`, where exp(i w t) is `turn`; the mean of theta'' over the cycle before."""
        if self._cycle is None:
            self._position[:] = position_rad
            self._recent.extend([position_rad] * (2 * self._reach))
        skipped = 0 if self._cycle is None else min(cycle - self._cycle - 1, self._cycles)
        self._cycle = cycle
        recent = self._recent
        for back in range(skipped, -1, -1):
            here = cycle - back
            recent.append(position_rad)
            if not skipped:
                self._learn_noise()
            self._place(here, position_rad)
        for i, one in enumerate(turn):
            step = self._gain[i] * mean_acceleration_rad_s2 * one.conjugate() * self._half_back[i]
            for back in range(skipped, 0, -1):  # cycles that never came: the same load at their own phase
                self.sum[i] += step * exp(1j * self._w[i] * back * self._cycle_s)
                self._held[(cycle - back) % self._cycles, i] = self.sum[i]
            self.sum[i] += step
            self.increment[i] = step
            self._held[cycle % self._cycles, i] = self.sum[i]

    def _place(self, cycle: int, position_rad: float) -> None:
        """Hold a joint at rest at its mean position, and correct the cycles that passed before the rest was noticed."""
        joint, cycles = self._joint, self._cycles
        changed = joint.see(position_rad, self._noise)
        position, rate = position_rad, (position_rad - self._recent[0]) * self._per_s
        if not joint.resting:
            self._moved_cycle = cycle
        elif not changed:
            position, rate = joint.held_rad, 0.0
        self._position[cycle % cycles] = position
        self._rate[cycle % cycles] = rate  # for want of what comes after it
        self._rate[(cycle - self._reach) % cycles] = rate
        if changed:
            self._rewrite(cycle)

    def _rewrite(self, cycle: int) -> None:
        joint, recent = self._joint, list(self._joint.recent)
        places = np.arange(cycle - len(recent) + 1, cycle + 1) % self._cycles
        if joint.resting:
            self._position[places], self._rate[places] = joint.held_rad, 0.0
            return
        self._position[places] = recent
        reach = self._reach
        rates = (np.array(recent[2 * reach :]) - np.array(recent[: -2 * reach])) * self._per_s
        self._rate[places[reach:-reach]] = rates

    def _learn_noise(self) -> None:
        """The encoder's noise, from third differences: a drive's own motion has next to none over a few cycles."""
        recent, assumed = self._recent, self._assumed
        if len(recent) < 4:
            return
        third = recent[-1] - recent[-4] + 3.0 * (recent[-3] - recent[-2])
        if self._noise_count < assumed.noise_cycles:
            self._noise_count = min(self._noise_count + 1.0, assumed.noise_cycles)
        self._noise += (third * third / assumed.third_difference - self._noise) / self._noise_count

    @property
    def position_variance(self) -> float:
        """Variance of theta by the encoder's noise, rad^2, of a joint that has lately moved: between two samples, two
        thirds of a sample's."""
        return self._assumed.between_samples * self._noise if self._moved_lately else 0.0

    @property
    def rate_variance(self) -> float:
        """Variance of theta' by the encoder's noise, rad^2/s^2, likewise."""
        return 2.0 * self._noise * self._per_s * self._per_s if self._moved_lately else 0.0

    @property
    def _moved_lately(self) -> bool:
        return (
            self._cycle is not None
            and self._cycle - self._moved_cycle < self._assumed.lately_s / self._cycle_s
        )

    def add(self, time_s: float, increment: list[complex]) -> None:
        """An impact at time_s, within the last second, has moved the phasors by `increment`."""
        newest = 0 if self._cycle is None else self._cycle
        first = ceil(time_s / self._cycle_s)
        for i, more in enumerate(increment):
            self.sum[i] += more
            for cycle in range(max(first, newest - self._cycles + 1), newest + 1):
                self._held[cycle % self._cycles, i] += more

    def position_at(self, time_s: float) -> float:
        """theta at an instant of the last second, rad: as seen_from, at a tenth of its cost."""
        newest = 0 if self._cycle is None else self._cycle
        place, oldest, latest = time_s / self._cycle_s, max(newest - self._cycles + 2.0, 0.0), newest - 1e-9
        if not place > oldest:  # NaN, too
            place = oldest
        place = min(place, latest)
        low = int(place)
        before = float(self._position[low % self._cycles])
        return before + (place - low) * (float(self._position[(low + 1) % self._cycles]) - before)

    def seen_from(self, edge_s: float, times_s: Array) -> tuple[Array, Array, ComplexArray]:
        """At k instants of the last second: theta, rad, theta', rad/s, and what G has grown by since edge_s.

        Shapes (k,), (k,), (k, m). theta' is taken over 4 ms, which the last 2 ms lack.
        """
        k, modes = len(times_s), len(self._w)
        asked = np.empty(k + 1)
        asked[:k], asked[k] = times_s, edge_s
        newest = 0 if self._cycle is None else self._cycle
        oldest = max(newest - self._cycles + 2.0, 0.0)
        # fmin and fmax turn NaN into the oldest: cast to an integer it would keep take(mode="wrap") busy for ever
        places = np.fmin(np.fmax(asked / self._cycle_s, oldest), newest - 1e-9)
        low = places.astype(np.int64)
        before = self._held.take(low, axis=0, mode="wrap")
        after = self._held.take(low + 1, axis=0, mode="wrap")
        seen = before + (places - low)[:, None] * (after - before)
        joint = seen[:k, modes]
        return joint.real, joint.imag, seen[:k, :modes] - seen[k, :modes]
