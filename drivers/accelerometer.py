"""The one interface behind which every accelerometer stands."""

from typing import Protocol

STANDARD_GRAVITY_M_S2 = 9.80665


class Accelerometer(Protocol):
    """One axis of an accelerometer. Constructing opens nothing; start() does, and raises UserError with a remedy."""

    delay_s: float  # group delay of the filter setting in use

    def start(self) -> None:
        """Open the bus, check the identity, set rate and range, wait until samples come."""

    def read(self) -> float:
        """The newest acceleration along the configured axis, m/s^2; NaN when the bus did not answer or data are stale.

        Never raises for a fault of the bus: a fault is a missing sample, and is counted in `faults`.
        """

    faults: int

    def close(self) -> None:
        """Release the bus; may be called twice."""
