"""A method across restarts: of the supervisor, whose displacements then have another zero, and of the method itself.

Images of two zeros in one fit look like a large vibration, and would be damped as one.
"""

from collections.abc import Callable
from math import isfinite, nan

import msgspec

from controller.estimate import DelayEstimate, Estimate, Method, Observation, OutlivesSupervisor, Status

_FAILED = "numbers out of range: started again"
_KNOWN = (Status.ESTIMATED, Status.HELD)


class MethodAcrossRestarts:
    """Begins anew with the first sample of a supervisor that was started anew. 5 to 200 us, once, for the making. A method
    that can tell the zero of images from all else is told of it instead, and keeps what it knows.

    A method whose numbers have left the range of floats would never come back by itself: it begins anew as well.
    failures: how often that has happened.
    """

    def __init__(self, make: Callable[[], Method]) -> None:
        """`make` gives a fresh method each time."""
        self._make = make
        self._method = make()
        self.failures = 0

    def update(self, observation: Observation) -> Estimate:
        """As the method's."""
        samples = observation.samples
        for place in range(len(samples) - 1, -1, -1):
            if samples[place].restarted:
                self._see_new_zero()
                if place:  # of the supervisor before
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
