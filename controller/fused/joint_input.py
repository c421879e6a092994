"""What the joint's known acceleration adds to each mode's phasor, summed up, with the last second of it."""

from cmath import exp
from math import expm1, floor, pi

from common.model import Drive

_HELD = 1024  # cycles


class JointInput:
    """Sum G of the phasor increments -i (dv / w) exp(-i w t), dv = - participation length theta'' dt, per mode.

    Between two instants an undamped, correctly tuned phasor moves by the difference of G; docs/fused.md, section 1.
    """

    def __init__(self, w: list[float], gain: list[float], drive: Drive, cycle_s: float) -> None:
        """w: damped angular frequency of each mode, rad/s; gain: - participation length / w."""
        # The command is held over a cycle, in which theta'' decays with the drive's lag: its mean is above its end.
        rate = 2.0 * pi * drive.bandwidth_hz * cycle_s
        self._mean_of_end = expm1(rate) / rate
        self._limit = drive.max_acceleration_rad_s2
        self._cycle_s = cycle_s
        self._w = w
        self._gain = [-1j * g * cycle_s for g in gain]
        self._half_back = [exp(0.5j * one * cycle_s) for one in w]
        self._held = [[0j] * _HELD for _ in w]
        self._position = [0.0] * _HELD
        self._cycle: int | None = None
        self.sum = [0j] * len(w)
        self.increment = [0j] * len(w)

    def advance(
        self, cycle: int, turn: list[complex], acceleration_rad_s2: float, position_rad: float
    ) -> None:
        """Move on to `cycle`, where exp(i w t) is `turn`; theta'' as it is at the end of the cycle before."""
        mean = min(max(acceleration_rad_s2 * self._mean_of_end, -self._limit), self._limit)
        skipped = 0 if self._cycle is None else min(cycle - self._cycle - 1, _HELD)
        self._cycle = cycle
        for back in range(skipped, -1, -1):
            self._position[(cycle - back) % _HELD] = position_rad
        for i, one in enumerate(turn):
            step = self._gain[i] * mean * one.conjugate() * self._half_back[i]
            held = self._held[i]
            for back in range(skipped, 0, -1):  # cycles that never came: the same load at their own phase
                self.sum[i] += step * exp(1j * self._w[i] * back * self._cycle_s)
                held[(cycle - back) % _HELD] = self.sum[i]
            self.sum[i] += step
            self.increment[i] = step
            held[cycle % _HELD] = self.sum[i]

    def position_at(self, time_s: float) -> float:
        """theta at an instant of the last second, rad."""
        if self._cycle is None:
            return 0.0
        place = min(max(time_s / self._cycle_s, self._cycle - _HELD + 2.0), float(self._cycle))
        low = floor(place)
        before = self._position[low % _HELD]
        fraction = place - low
        return before + fraction * (self._position[(low + 1) % _HELD] - before) if fraction > 0.0 else before

    def at(self, mode: int, time_s: float) -> complex:
        """G of a mode at an instant of the last second."""
        if self._cycle is None:
            return 0j
        place = min(max(time_s / self._cycle_s, self._cycle - _HELD + 2.0), float(self._cycle))
        low = floor(place)
        held = self._held[mode]
        before = held[low % _HELD]
        fraction = place - low
        return before + fraction * (held[(low + 1) % _HELD] - before) if fraction > 0.0 else before
