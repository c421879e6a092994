"""Restarts a method with the supervisor, whose displacements then have another zero, and after a numerical failure.

In one fit, images with two zeros look like a large vibration, and would be damped as one.
"""

from collections.abc import Callable
from math import isfinite, nan

import msgspec

from stillarm.controller.estimation.estimate import (
    DelayEstimate,
    Estimate,
    Method,
    Observation,
    OutlivesSupervisor,
    Status,
)

_FAILED = "numbers out of range: started again"
_KNOWN = (Status.ESTIMATED, Status.HELD)


class MethodAcrossRestarts:
    """Restarts the method at the first sample of a restarted supervisor, which takes 5 to 200 us once. A method that
    can separate the zero of the images from everything else is told of the new zero instead, and keeps what it knows.

    A method whose numbers have left the range of floats would never recover by itself, and is restarted as well.
    failures: number of such restarts.
    """

    def __init__(self, make: Callable[[], Method]) -> None:
        """make: returns a new method."""
        self._make = make
        self._method = make()
        self.failures = 0

    def update(self, observation: Observation) -> Estimate:
        """As the method's."""
        samples = observation.samples
        for place in range(len(samples) - 1, -1, -1):
            if samples[place].restarted:
                self._see_new_zero()
                if place:  # samples of the previous supervisor
                    observation = msgspec.structs.replace(observation, samples=samples[place:])
                break
        try:
            estimate = self._method.update(observation)
        except (ArithmeticError, ValueError):  # LinAlgError is a ValueError
            return self._failed()
        if estimate.status in _KNOWN and not isfinite(
            estimate.deflection_m + estimate.deflection_rate_m_s + estimate.delay.delay_s
        ):
            return self._failed()
        return estimate

    def _see_new_zero(self) -> None:
        if isinstance(self._method, OutlivesSupervisor):
            self._method.see_new_zero()
        else:
            self._method = self._make()

    def _failed(self) -> Estimate:
        self.failures += 1
        self._method = self._make()
        return Estimate(DelayEstimate(nan, nan, Status.INVALID), status=Status.INVALID, reason=_FAILED)
