"""The registers of an emulated LIS3LV02DQ, in memory shared by the rig, which feels, and the driver's
process.

Layout of the block's payload: 128 bytes of registers, of which the bus side writes all but the samples; at
128 the newest sample (sequence lock, count of samples, x, y, z in counts), written by the rig alone; at 160
the count up to which each axis has been read, written by the bus side alone; at 184 the injected failure.
Not emulated: self-test, high-pass filter, interrupts, offset and gain trimming (their registers only store).
"""

import struct
from enum import IntEnum
from typing import Literal

from common.shared_memory import SharedBlock, word_at
from drivers.accelerometer import STANDARD_GRAVITY_M_S2

WHO_AM_I, CTRL1, CTRL2, CTRL3, STATUS, OUT_X_L = 0x0F, 0x20, 0x21, 0x22, 0x27, 0x28
IDENTITY = 0x3A
POWER_UP_MASK, RATE_MASK, AXES_MASK = 0xC0, 0x30, 0x07
SIX_G, BLOCK_UPDATE, BIG_ENDIAN, LEFT_JUSTIFIED = 0x80, 0x40, 0x20, 0x01
_RATES_HZ = (40.0, 160.0, 640.0, 2560.0)
_COUNTS_PER_G = {False: 1024.0, True: 340.0}
_LOWEST, _HIGHEST = -2048, 2047  # 12 bit

_REGISTERS = 128
_SAMPLE_AT, _READ_AT, _FAILURE_AT, _SIZE = 128, 160, 184, 192
_SAMPLE = struct.Struct("<Q3h")
_READ = struct.Struct("<3Q")


class Failure(IntEnum):
    """What can be made to fail. NAK: no acknowledge. STUCK: no new data any more. GARBAGE: random data
    bytes."""

    NONE = 0
    NAK = 1
    STUCK = 2
    WRONG_IDENTITY = 3
    GARBAGE = 4


def sensed_axes(acceleration_m_s2: float, axis: Literal["x", "y", "z"]) -> tuple[float, float, float]:
    """What the sensor feels on (x, y, z), m/s^2, mounted with `axis` along the measured motion.

    Of the two others one is horizontal, feeling nothing, and one (z, or y where z is measured) feels gravity.
    """
    if axis == "x":
        return acceleration_m_s2, 0.0, STANDARD_GRAVITY_M_S2
    if axis == "y":
        return 0.0, acceleration_m_s2, STANDARD_GRAVITY_M_S2
    return 0.0, STANDARD_GRAVITY_M_S2, acceleration_m_s2


class Lis3lv02dqRegisters:
    """The sensing side: made by the rig, which publishes what the sensor feels. Powered down until a driver
    sets it up."""

    def __init__(self, name: str, period_s: float = 0.001) -> None:
        """Make the registers `name` (a bus "memory:NAME" leads to them) in their state after power-up.

        period_s: time from one publish() to the next; output rates slower than that pass samples over.
        """
        self._block = SharedBlock(name, _SIZE, create=True)
        buffer = self._block.buffer
        self._buffer = buffer
        self._lock = word_at(buffer, _SAMPLE_AT)
        buffer[WHO_AM_I], buffer[CTRL1], buffer[CTRL3] = IDENTITY, AXES_MASK, 0x08
        self._period_s = period_s
        self._phase = 0.0
        self._sequence = 0
        self._count = 0

    def publish(self, acceleration_xyz_m_s2: tuple[float, float, float]) -> None:
        """Feel an acceleration: quantise it by the range that CTRL2 sets, at the rate that CTRL1 sets.

        Values beyond the range are clipped to it. Powered down, nothing happens.
        """
        buffer = self._buffer
        control = buffer[CTRL1]
        if not control & POWER_UP_MASK or buffer[_FAILURE_AT] == Failure.STUCK:
            return
        self._phase += min(1.0, _RATES_HZ[(control & RATE_MASK) >> 4] * self._period_s)
        if self._phase < 1.0 - 1e-9:
            return
        self._phase -= 1.0
        counts_per_m_s2 = _COUNTS_PER_G[buffer[CTRL2] & SIX_G != 0] / STANDARD_GRAVITY_M_S2
        x, y, z = [min(max(round(a * counts_per_m_s2), _LOWEST), _HIGHEST) for a in acceleration_xyz_m_s2]
        self._count += 1
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


class SharedRegisters:
    """The bus side's view of the registers that a rig made."""

    def __init__(self, name: str, wait_s: float = 0.0) -> None:
        """Open the registers `name`, waiting up to `wait_s` for them. Raises UserError when there are
        none."""
        self._block = SharedBlock(name, create=False, wait_s=wait_s)
        self.buffer = self._block.buffer
        self._lock = word_at(self.buffer, _SAMPLE_AT)

    @property
    def failure(self) -> int:
        """The injected failure, a value of Failure."""
        return self.buffer[_FAILURE_AT]

    def sample(self) -> tuple[int, int, int, int] | None:
        """(count of samples so far, x, y, z in counts), whole; None where the rig died while writing."""
        buffer, lock = self.buffer, self._lock
        for _ in range(1000):
            sequence = lock[0]
            count, x, y, z = _SAMPLE.unpack_from(buffer, _SAMPLE_AT + 8)
            if not sequence & 1 and lock[0] == sequence:
                return count, x, y, z
        return None

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
