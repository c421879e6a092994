"""The registers of an emulated accelerometer, in memory shared by the rig, which senses, and the driver's process.

Layout of the block's payload: 512 bytes of registers (four banks of 128), of which the bus side writes all but the
samples; at 512 the newest sample (sequence lock, count of samples, x, y, z in counts), written by the rig alone; at 544
the count up to which each axis has been read, written by the bus side alone; at 568 the injected failure; at 569 the
part's number; at 576 a ring of the last 256 samples, for the FIFO, written by the rig before the count.
"""

import errno
import struct
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum

from stillarm.common.memory.shared_memory import SharedBlock, word_at
from stillarm.common.user_error import UserError
from stillarm.drivers.standard_gravity import STANDARD_GRAVITY_M_S2

REGISTERS = 512
RING = 256
LATE_S = 0.003
_SAMPLE_AT, _READ_AT, _FAILURE_AT, PART_AT, _RING_AT = 512, 544, 568, 569, 576
_SAMPLE = struct.Struct("<Q3i")
_READ = struct.Struct("<3Q")
_RING_SAMPLE = struct.Struct("<3i")
_SIZE = _RING_AT + RING * _RING_SAMPLE.size


class Failure(IntEnum):
    """Failures to inject. NAK: no acknowledge. STUCK: no new data. GARBAGE: random data bytes. LATE: transfers take
    3 ms. UNPLUGGED: no acknowledge, and the settings are lost.
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
    """The part's settings: sample rate, counts per acceleration, and their limits."""

    rate_hz: float
    counts_per_g: float
    lowest: int
    highest: int


@dataclass(frozen=True)
class SensedPart:
    """The sensing side of a part. number: identifies it to the bus side. power_up: registers that are not zero.

    sensing: from the registers; None while the part sleeps.
    """

    name: str
    number: int
    power_up: Mapping[int, int]
    sensing: Callable[[memoryview], Sensing | None]


class SensedRegisters:
    """The sensing side. The rig makes it and publishes accelerations. It has its power-up state until a driver sets it
    up."""

    def __init__(self, name: str, part: SensedPart, period_s: float = 0.001) -> None:
        """Make the registers `name` (for the bus "memory:NAME") in their state after power-up.

        period_s: time from one publish() to the next; slower output rates skip samples.
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
        """Set the acceleration: quantise it with the registers' range, at the registers' rate.

        Values beyond the range are clipped. Nothing happens while the part sleeps.
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
        """Make the device fail from now on; Failure.NONE repairs it."""
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
        """Open the registers `name`, waiting up to `wait_s` for them. Raises UserError if there are none."""
        self._block = SharedBlock(name, create=False, wait_s=wait_s)
        self.buffer = self._block.buffer
        self._lock = word_at(self.buffer, _SAMPLE_AT)

    @property
    def part_number(self) -> int:
        """Number of the part for which the rig made these registers."""
        return self.buffer[PART_AT]

    @property
    def failure(self) -> int:
        """The injected failure, a value of Failure."""
        return self.buffer[_FAILURE_AT]

    def inject(self, failure: Failure) -> None:
        """Make the device fail, as SensedRegisters.inject() does, from a process other than the rig's."""
        self.buffer[_FAILURE_AT] = failure

    def sample(self) -> tuple[int, int, int, int] | None:
        """(count of samples so far, x, y, z in counts), consistent; None if the rig died while writing."""
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
        """Set the sample count up to which each axis has been read."""
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
    """The new registers of a restarted rig (a device that lost its power and settings), with the old ones closed; the
    same registers if the rig did not restart, or has not made new ones yet."""
    if not registers.replaced():
        return registers
    try:
        fresh = SharedRegisters(name)
    except UserError:
        return registers  # still absent
    registers.close()
    return fresh


def raise_failure(failure: int) -> None:
    """Effect of an injected failure on the bus: a late answer, or OSError (EREMOTEIO) for none."""
    if failure == Failure.LATE:
        time.sleep(LATE_S)
    elif failure in (Failure.NAK, Failure.UNPLUGGED):
        raise OSError(errno.EREMOTEIO, "Remote I/O error")
