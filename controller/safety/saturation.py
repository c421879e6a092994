"""Distinguishes damping that stays at its limit without effect from damping that reduces a large vibration."""

from math import exp, isfinite

_OVER_S = 1.5
_SHARE = 0.5  # of the cycles at the limit
_LOOK_EVERY_S = 1.5
_FALLEN = 0.9  # of the amplitude at the last check: below it the damping has an effect


class SaturationTest:
    """Fraction of the cycles at the limit, and the amplitude in that time."""

    def __init__(self, cycle_s: float) -> None:
        """Nothing seen so far."""
        self._cycle_s = cycle_s
        self._gain = 1.0 - exp(-cycle_s / _OVER_S)
        self.restart()

    def restart(self) -> None:
        """Nothing seen so far."""
        self._share = self._passed_s = self._greatest_m = 0.0
        self._before_m: float | None = None

    def lasts(self, elapsed: int, at_limit: bool, amplitude_m: float) -> bool:
        """Process a cycle. Returns True if more than half of the cycles were at the limit, and the amplitude has not
        fallen by a tenth from one check to the next, every 1.5 s.
        """
        passed = elapsed * self._cycle_s
        gain = self._gain if elapsed == 1 else 1.0 - exp(-passed / _OVER_S)
        self._share += gain * ((1.0 if at_limit else 0.0) - self._share)
        if self._share < _SHARE:
            self._passed_s, self._before_m, self._greatest_m = 0.0, None, 0.0
            return False
        if isfinite(amplitude_m):
            self._greatest_m = max(self._greatest_m, amplitude_m)
        self._passed_s += passed
        if self._passed_s < _LOOK_EVERY_S:
            return False
        before, now = self._before_m, self._greatest_m
        self._before_m, self._passed_s, self._greatest_m = now, 0.0, 0.0
        return before is not None and now > _FALLEN * before
