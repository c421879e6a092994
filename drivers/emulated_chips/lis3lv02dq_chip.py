"""The bus side of an emulated LIS3LV02DQ: its answers to the bytes of I2C messages.

A write sends the register's address, whose bit 7 requests auto-increment, and then the values. A read continues from
there. Reading the higher byte of an axis's pair clears its data-ready flag. With block data update, an axis whose lower
byte was read keeps its value until its higher byte is read.
"""

import struct

from stillarm.drivers.emulated_chips.lis3lv02dq_registers import (
    AXES_MASK,
    BIG_ENDIAN,
    BLOCK_UPDATE,
    CTRL1,
    CTRL2,
    LEFT_JUSTIFIED,
    OUT_X_L,
    STATUS,
    WHO_AM_I,
)
from stillarm.drivers.emulated_chips.shared_registers import Failure, SharedRegisters, raise_failure, reopened

_AUTO_INCREMENT = 0x80
_OUT_END = OUT_X_L + 6
_READ_ONLY = frozenset((WHO_AM_I, *range(STATUS, _OUT_END)))
_LITTLE, _BIG = struct.Struct("<3h"), struct.Struct(">3h")
_ALL_READY, _ALL_OVERRUN = 0x08, 0x80
_LOOK_FOR_RESTART = 256  # status reads without new data between checks of the file system


class Lis3lv02dqChip:
    """Answers for registers in shared memory; stillarm.drivers.buses.i2c_adapter.I2cDevice.

    The register pointer and the values held by block data update belong to this object: each process that opens the bus
    has its own.
    """

    def __init__(self, name: str) -> None:
        """Open the registers `name` that a rig made. Raises UserError if there are none."""
        self._name = name
        self._registers = SharedRegisters(name)
        self._pointer = 0
        self._increment = 0
        self._held = [False, False, False]
        self._counts = [0, 0, 0]  # the sample count that each axis's output bytes belong to
        self._idle = 0
        self._noise = 1

    def write(self, data: bytes) -> None:
        """Process the bytes of a write message. Raises OSError (EREMOTEIO) if the device does not acknowledge."""
        self._acknowledge()
        if not data:
            return
        self._pointer, self._increment = data[0] & 0x7F, 1 if data[0] & _AUTO_INCREMENT else 0
        for value in data[1:]:
            if self._pointer not in _READ_ONLY:
                self._registers.buffer[self._pointer] = value
            self._pointer = (self._pointer + self._increment) & 0x7F

    def read(self, length: int) -> bytes:
        """The bytes of a read message. Raises OSError (EREMOTEIO) if the device does not acknowledge."""
        self._acknowledge()
        first = self._pointer
        if not self._increment:
            return b"".join(self._read_span(first, 1) for _ in range(length))
        end = first + length
        self._pointer = end & 0x7F
        if end <= 128:
            return self._read_span(first, length)
        return b"".join(self._read_span((first + offset) & 0x7F, 1) for offset in range(length))

    def close(self) -> None:
        """Release the memory; may be called twice."""
        self._registers.close()

    def _acknowledge(self) -> None:
        if self._idle >= _LOOK_FOR_RESTART:
            self._idle = 0
            registers = reopened(self._registers, self._name)
            if registers is not self._registers:
                self._registers = registers
                self._held, self._counts = [False, False, False], [0, 0, 0]
        try:
            raise_failure(self._registers.failure)
        except OSError:
            self._idle += 1
            raise

    def _read_span(self, first: int, length: int) -> bytes:
        end = first + length
        if first < _OUT_END and end > STATUS:
            self._refresh()
        data = bytes(self._registers.buffer[first:end])
        if first < _OUT_END and end > OUT_X_L:
            self._mark_read(first, end)
            if self._registers.failure == Failure.GARBAGE:
                return bytes(
                    self._random() if OUT_X_L <= first + i < _OUT_END else b for i, b in enumerate(data)
                )
        if first <= WHO_AM_I < end and self._registers.failure == Failure.WRONG_IDENTITY:
            place = WHO_AM_I - first
            data = data[:place] + bytes((data[place] ^ 0xFF,)) + data[place + 1 :]
        return data

    def _refresh(self) -> None:
        """Update status and output registers to the newest sample."""
        registers = self._registers
        buffer = registers.buffer
        enabled = buffer[CTRL1] & AXES_MASK
        sample = registers.sample()
        if sample is None or not enabled:
            self._idle += 1
            buffer[STATUS] = 0
            return
        count, x, y, z = sample
        held = self._held
        if buffer[CTRL2] & LEFT_JUSTIFIED:
            x, y, z = x << 4, y << 4, z << 4
        layout = _BIG if buffer[CTRL2] & BIG_ENDIAN else _LITTLE
        if enabled == AXES_MASK and not any(held):
            layout.pack_into(buffer, OUT_X_L, x, y, z)
            self._counts[:] = count, count, count
        else:
            fresh = layout.pack(x, y, z)
            for axis in range(3):
                if enabled >> axis & 1 and not held[axis]:
                    place = OUT_X_L + 2 * axis
                    buffer[place : place + 2] = fresh[2 * axis : 2 * axis + 2]
                    self._counts[axis] = count
        status = _status(enabled, count, registers.read_counts())
        self._idle = 0 if status else self._idle + 1
        buffer[STATUS] = status

    def _mark_read(self, first: int, end: int) -> None:
        """Note which axes a read of the registers first .. end - 1 releases, and which it holds."""
        if first <= OUT_X_L and end >= _OUT_END:
            self._registers.set_read_counts(*self._counts)
            self._held = [False, False, False]
            return
        block_update = self._registers.buffer[CTRL2] & BLOCK_UPDATE
        taken = list(self._registers.read_counts())
        for axis in range(3):
            low = OUT_X_L + 2 * axis
            if first <= low + 1 < end:
                taken[axis] = max(taken[axis], self._counts[axis])
                self._held[axis] = False
            elif block_update and first <= low < end:
                self._held[axis] = True
        self._registers.set_read_counts(*taken)

    def _random(self) -> int:
        """A pseudo-random byte (Numerical Recipes' linear congruence): garbage that repeats from run to run."""
        self._noise = (self._noise * 1664525 + 1013904223) & 0xFFFFFFFF
        return self._noise >> 24


def _status(enabled: int, count: int, taken: tuple[int, int, int]) -> int:
    """The status register: data ready and overrun for each axis, and for all enabled axes."""
    ready = overrun = 0
    if taken[0] == taken[1] == taken[2]:  # as after every burst
        ready, overrun = (enabled if count > taken[0] else 0), (enabled if count > taken[0] + 1 else 0)
    else:
        for axis in range(3):
            ready |= (count > taken[axis]) << axis & enabled
            overrun |= (count > taken[axis] + 1) << axis & enabled
    all_ready = _ALL_READY if ready == enabled else 0
    all_overrun = _ALL_OVERRUN if overrun == enabled else 0
    return ready | all_ready | overrun << 4 | all_overrun
