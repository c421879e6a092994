"""The interface of every accelerometer."""

from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol


class SampleStatus(IntEnum):
    """Result of a read. All but the first two are faults, and their sample is NaN."""

    FRESH = 0
    HELD = 1  # no newer sample yet: the last one is used
    STALE = 2  # no newer sample for so long that the last one is no longer used
    NO_ANSWER = 3  # the bus or port did not answer, or not in time
    IMPLAUSIBLE = 4  # the bytes cannot be a sample
    SETTING_UP = 5  # absent, or being set up again


@dataclass(frozen=True)
class Reading:
    """Details of a read: m/s^2 along the sensor's own axes, before mounting and bias; the driver's status, and the
    device's status byte (-1: none); the host's monotonic time of the read, s; the device's own time, s (NaN: none).
    """

    acceleration_xyz_m_s2: tuple[float, float, float]
    status: SampleStatus
    device_status: int
    read_s: float
    device_time_s: float


class Accelerometer(Protocol):
    """One axis of an accelerometer. Constructing opens nothing; start() does, and raises UserError with a remedy.

    delay_s: group delay of the filter setting in use, at low frequency. rate_hz: sample rate that the device is set to.
    range_m_s2: the largest measurable acceleration. faults: reads without a sample since start().
    """

    delay_s: float
    rate_hz: float
    range_m_s2: float
    faults: int

    def start(self) -> None:
        """Open the bus, check the identity, set rate and range, wait for samples."""

    def identify(self) -> str:
        """The device's identity in words, after start(). Not for use in a cycle."""

    def read(self) -> float:
        """The newest acceleration along the configured axis, m/s^2; NaN when the bus did not answer or data are stale.

        Never raises for a fault of the bus: a fault is a missing sample, and `faults` counts it. Never waits: a device
        that was unplugged is found and set up again in small steps, one per read.
        """

    def last_reading(self) -> Reading:
        """The details of the last read()."""

    def close(self) -> None:
        """Release the bus; may be called twice."""


class BlockAccelerometer(Protocol):
    """An accelerometer with a FIFO, for logging: a block of N samples is up to N sample periods old."""

    def start_blocks(self) -> None:
        """Empty the FIFO and switch it on. Raises UserError if the part has none, OSError if the bus fails."""

    def read_block(self) -> list[tuple[float, float, float]]:
        """The samples since the last call, oldest first, m/s^2 along the sensor's axes. Raises OSError."""

    def stop_blocks(self) -> None:
        """Switch the FIFO off again. Raises OSError."""
