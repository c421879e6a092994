"""The one interface behind which every accelerometer stands."""

from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol


class SampleStatus(IntEnum):
    """What a read gave. All but the first two are faults, and their sample is no number."""

    FRESH = 0
    HELD = 1  # no newer sample yet: the last one stands
    STALE = 2  # no newer sample for so long that the last one stands no more
    NO_ANSWER = 3  # the bus or port did not answer, or not in time
    IMPLAUSIBLE = 4  # what came cannot be a sample
    SETTING_UP = 5  # away, or being set up again


@dataclass(frozen=True)
class Reading:
    """All that a read gave: m/s^2 along the sensor's own axes, before mounting and bias; the status that the driver
    concludes, and the byte that the device gave (-1: it gives none); the host's monotonic time of the read, s; the
    device's own time, s (NaN: it has none).
    """

    acceleration_xyz_m_s2: tuple[float, float, float]
    status: SampleStatus
    device_status: int
    read_s: float
    device_time_s: float


class Accelerometer(Protocol):
    """One axis of an accelerometer. Constructing opens nothing; start() does, and raises UserError with a remedy.

    delay_s: group delay of the filter setting in use, at low frequency. rate_hz: samples a second that the device is
    set to. range_m_s2: the largest acceleration that it measures. faults: reads that gave no sample since start().
    """

    delay_s: float
    rate_hz: float
    range_m_s2: float
    faults: int

    def start(self) -> None:
        """Open the bus, check the identity, set rate and range, wait until samples come."""

    def identify(self) -> str:
        """What the device says that it is, in words; after start(). Not for use in a cycle."""

    def read(self) -> float:
        """The newest acceleration along the configured axis, m/s^2; NaN when the bus did not answer or data are stale.

        Never raises for a fault of the bus: a fault is a missing sample, and is counted in `faults`. Never waits:
        a device that was unplugged is looked for, and set up again, a small step a read.
        """

    def last_reading(self) -> Reading:
        """The details of the last read()."""

    def close(self) -> None:
        """Release the bus; may be called twice."""


class BlockAccelerometer(Protocol):
    """An accelerometer with a FIFO, for logging: a block of N samples is up to N sample periods old."""

    def start_blocks(self) -> None:
        """Switch the FIFO on, empty. Raises UserError where the part has none, OSError where the bus fails."""

    def read_block(self) -> list[tuple[float, float, float]]:
        """The samples since the last call, oldest first, m/s^2 along the sensor's axes. Raises OSError."""

    def stop_blocks(self) -> None:
        """Switch the FIFO off again. Raises OSError."""
