"""A method across restarts of the supervisor, whose displacements have another zero each time.

Images of two zeros in one fit look like a large vibration, and would be damped as one.
"""

from collections.abc import Callable

import msgspec

from controller.estimate import Estimate, Method, Observation


class MethodAcrossRestarts:
    """Begins anew with the first sample of a supervisor that was started anew. 5 to 200 us, once, for the making."""

    def __init__(self, make: Callable[[], Method]) -> None:
        """`make` gives a fresh method each time."""
        self._make = make
        self._method = make()

    def update(self, observation: Observation) -> Estimate:
        """As the method's."""
        samples = observation.samples
        for place in range(len(samples) - 1, -1, -1):
            if samples[place].restarted:
                self._method = self._make()
                if place:  # of the supervisor before
                    observation = msgspec.structs.replace(observation, samples=samples[place:])
                break
        return self._method.update(observation)
