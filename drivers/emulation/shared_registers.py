"""The registers of an emulated accelerometer, in memory shared by the rig, which feels, and the driver's process.

Layout of the block's payload: 512 bytes of registers (four banks of 128), of which the bus side writes all but the
samples; at 512 the newest sample (sequence lock, count of samples, x, y, z in counts), written by the rig alone; at 544
the count up to which each axis has been read, written by the bus side alone; at 568 the injected failure; at 569 which
part it is; at 576 a ring of the last 256 samples, for the FIFO, written by the rig before the count.
"""

import errno
import struct
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum

from common.shared_memory import SharedBlock, word_at
from common.user_error import UserError
from drivers.standard_gravity import STANDARD_GRAVITY_M_S2

REGISTERS = 512
RING = 256
LATE_S = 0.003
_SAMPLE_AT, _READ_AT, _FAILURE_AT, PART_AT, _RING_AT = 512, 544, 568, 569, 576
_SAMPLE = struct.Struct("<Q3i")
_READ = struct.Struct("<3Q")
_RING_SAMPLE = struct.Struct("<3i")
_SIZE = _RING_AT + RING * _RING_SAMPLE.size


class Failure(IntEnum):
    """What can be made to fail. NAK: no acknowledge. STUCK: no new data any more. GARBAGE: random data bytes. LATE:
    transfers take 3 ms. UNPLUGGED: no acknowledge, and the settings are lost.
    """

    NONE = 0
    NAK = 1
    STUCK = 2
    WRONG_IDENTITY = 3
    GARBAGE = 4
    LATE = 5
    UNPLUGGED = 6


@dataclass(frozen=True)
class Sensing:
    """What the part's registers make it do: samples a second, counts for an acceleration, and where they end."""

    rate_hz: float
    counts_per_g: float
    lowest: int
    highest: int


@dataclass(frozen=True)
class SensedPart:
    """The sensing side of a part. number: tells the bus side which it is. power_up: registers that are not zero.

    sensing: from the registers; None while the part sleeps.
    """

    name: str
    number: int
    power_up: Mapping[int, int]
    sensing: Callable[[memoryview], Sensing | None]


class SensedRegisters:
    """The sensing side: made by the rig, which publishes what the sensor feels. As after power-up until a driver
    sets it up."""

    def __init__(self, name: str, part: SensedPart, period_s: float = 0.001) -> None:
        """Make the registers `name` (a bus "memory:NAME" leads to them) in their state after power-up.

        period_s: time from one publish() to the next; output rates slower than that pass samples over.
        """
        self._block = SharedBlock(name, _SIZE, create=True)
        self._buffer = self._block.buffer
        self._lock = word_at(self._buffer, _SAMPLE_AT)
        self._part = part
        self._period_s = period_s
        self._phase = 0.0
        self._sequence = 0
        self._count = 0
        self._without_power = False
        self._power_up()
        self._buffer[PART_AT] = part.number

    def publish(self, acceleration_xyz_m_s2: tuple[float, float, float]) -> None:
        """Feel an acceleration: quantise it by the range that the registers set, at the rate that they set.

        Values beyond the range are clipped to it. Asleep, nothing happens.
        """
        buffer = self._buffer
        failure = buffer[_FAILURE_AT]
        if failure == Failure.UNPLUGGED and not self._without_power:
            self._power_up()
        self._without_power = failure == Failure.UNPLUGGED
        if failure in (Failure.STUCK, Failure.UNPLUGGED):
            return
        sensing = self._part.sensing(buffer)
        if sensing is None:
            return
        self._phase += min(1.0, sensing.rate_hz * self._period_s)
        if self._phase < 1.0 - 1e-9:
            return
        self._phase -= 1.0
        per_m_s2, lowest, highest = (
            sensing.counts_per_g / STANDARD_GRAVITY_M_S2,
            sensing.lowest,
            sensing.highest,
        )
        x, y, z = [min(max(round(a * per_m_s2), lowest), highest) for a in acceleration_xyz_m_s2]
        self._count += 1
        _RING_SAMPLE.pack_into(buffer, _RING_AT + self._count % RING * _RING_SAMPLE.size, x, y, z)
        self._lock[0] = self._sequence + 1
        _SAMPLE.pack_into(buffer, _SAMPLE_AT + 8, self._count, x, y, z)
        self._sequence += 2
        self._lock[0] = self._sequence

    def inject(self, failure: Failure) -> None:
        """Make the device fail from now on; Failure.NONE mends it."""
        self._buffer[_FAILURE_AT] = failure

    def close(self) -> None:
        """Remove the registers; may be called twice."""
        self._buffer = memoryview(bytearray(_SIZE))
        self._lock.release()
        self._block.close()

    def _power_up(self) -> None:
        self._buffer[:REGISTERS] = bytes(REGISTERS)
        for register, value in self._part.power_up.items():
            self._buffer[register] = value


class SharedRegisters:
    """The bus side's view of the registers that a rig made."""

    def __init__(self, name: str, wait_s: float = 0.0) -> None:
        """Open the registers `name`, waiting up to `wait_s` for them. Raises UserError when there are
        none."""
        self._block = SharedBlock(name, create=False, wait_s=wait_s)
        self.buffer = self._block.buffer
        self._lock = word_at(self.buffer, _SAMPLE_AT)

    @property
    def part_number(self) -> int:
        """Which part the rig made these registers for."""
        return self.buffer[PART_AT]

    @property
    def failure(self) -> int:
        """The injected failure, a value of Failure."""
        return self.buffer[_FAILURE_AT]

    def inject(self, failure: Failure) -> None:
        """Make the device fail, as SensedRegisters.inject(), from another process than the rig's."""
        self.buffer[_FAILURE_AT] = failure

    def sample(self) -> tuple[int, int, int, int] | None:
        """(count of samples so far, x, y, z in counts), whole; None where the rig died while writing."""
        buffer, lock = self.buffer, self._lock
        for _ in range(1000):
            sequence = lock[0]
            count, x, y, z = _SAMPLE.unpack_from(buffer, _SAMPLE_AT + 8)
            if not sequence & 1 and lock[0] == sequence:
                return count, x, y, z
        return None

    def past_sample(self, count: int) -> tuple[int, int, int]:
        """The sample with that count, of the last 256."""
        return _RING_SAMPLE.unpack_from(self.buffer, _RING_AT + count % RING * _RING_SAMPLE.size)

    def read_counts(self) -> tuple[int, int, int]:
        """The sample count up to which each of x, y, z has been read."""
        return _READ.unpack_from(self.buffer, _READ_AT)

    def set_read_counts(self, x: int, y: int, z: int) -> None:
        """Note up to which sample each axis has been read."""
        _READ.pack_into(self.buffer, _READ_AT, x, y, z)

    def replaced(self) -> bool:
        """Whether the rig is gone or has made new registers."""
        return self._block.replaced()

    def close(self) -> None:
        """Release the memory; may be called twice."""
        self.buffer = memoryview(bytearray(_SIZE))
        self._lock.release()
        self._block.close()


def reopened(registers: SharedRegisters, name: str) -> SharedRegisters:
    """The registers of a rig that restarted and made new ones (a device that lost its power and its settings), the old
    ones closed; the same again where it did not, or has not yet."""
    if not registers.replaced():
        return registers
    try:
        fresh = SharedRegisters(name)
    except UserError:
        return registers  # not there yet
    registers.close()
    return fresh


def raise_failure(failure: int) -> None:
    """What the bus makes of an injected failure: a late answer, or OSError (EREMOTEIO) for none."""
    if failure == Failure.LATE:
        time.sleep(LATE_S)
    elif failure in (Failure.NAK, Failure.UNPLUGGED):
        raise OSError(errno.EREMOTEIO, "Remote I/O error")
