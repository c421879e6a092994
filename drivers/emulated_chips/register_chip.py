"""The bus side of emulated accelerometers with a plain register file: their answers to the bytes of I2C messages.

A write sends the register's address and then the values. A read continues from there. Each part is a ChipLayout: the
encoding of a sample, the meaning and release of its status, and the access to its FIFO.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from stillarm.drivers.emulated_chips.shared_registers import (
    Failure,
    SensedPart,
    SharedRegisters,
    raise_failure,
    reopened,
)

_LOOK_FOR_RESTART = 256  # transfers without new data between checks of the file system
_BANK = 128

Counts = tuple[int, int, int]
Encode = Callable[[memoryview, Counts], bytes]


@dataclass(frozen=True)
class ChipStatus:
    """Contents of a status register: unread samples, lost samples, whole samples in the FIFO, FIFO overrun."""

    fresh: bool
    overrun: bool
    entries: int
    fifo_overrun: bool


@dataclass(frozen=True)
class ChipFifo:
    """A FIFO of whole samples. When it is full, a new sample overwrites the oldest.

    window: the register through which it is read. counts: contents of the count registers. In a streaming FIFO the
    pointer stays on the window, and every byte read is the next one. Otherwise a read of the window loads the next
    sample into the data registers; if rolls is set, the pointer rolls over from their end.
    """

    on: Callable[[memoryview], bool]
    depth: int
    window: int
    streaming: bool
    counts: Callable[[ChipStatus], Mapping[int, int]]
    rolls: bool = False
    entry: Encode | None = None  # encoding of a sample in the FIFO, if it differs from the data registers


@dataclass(frozen=True)
class ChipLayout:
    """A part's bus side. Registers in banks count on: bank * 128 + register.

    auto_increment_bit: of the address byte; 0: the pointer always advances. read_frees: the register whose read clears
    the data-ready flag. written: side effect of a write, such as a reset; gets registers, place, value.
    """

    sensed: SensedPart
    address: int
    identity: range
    data: range
    encode: Encode
    status_register: int
    status: Callable[[memoryview, ChipStatus], int]
    read_frees: int
    read_only: frozenset[int]
    auto_increment_bit: int = 0
    bank_register: int = -1
    fifo: ChipFifo | None = None
    written: Callable[[memoryview, int, int], None] | None = None


class RegisterChip:
    """Answers for registers in shared memory; stillarm.drivers.buses.i2c_adapter.I2cDevice."""

    def __init__(self, layout: ChipLayout, name: str) -> None:
        """Open the registers `name` that a rig made. Raises UserError if there are none."""
        self._layout = layout
        self._name = name
        self._registers = SharedRegisters(name)
        self._pointer = 0
        self._increment = 1
        self._newest = 0  # the count of the sample in the data registers
        self._next_in_fifo: int | None = None  # count of the oldest sample in the FIFO; None while it is off
        self._byte_in_fifo = 0
        self._fifo_overrun = False
        self._idle = 0
        self._noise = 1

    def write(self, data: bytes) -> None:
        """Process the bytes of a write message. Raises OSError (EREMOTEIO) if the device does not acknowledge."""
        self._acknowledge()
        if not data:
            return
        layout = self._layout
        bit = layout.auto_increment_bit
        self._pointer = data[0] & ~bit & 0x7F
        self._increment = 1 if not bit or data[0] & bit else 0
        buffer = self._registers.buffer
        for value in data[1:]:
            place = self._place(self._pointer)
            if place not in layout.read_only:
                buffer[place] = value
                if layout.written is not None:
                    layout.written(buffer, place, value)
            self._pointer = (self._pointer + self._increment) & 0x7F
        sample = self._registers.sample()
        if layout.fifo is None or not layout.fifo.on(buffer):
            self._next_in_fifo = None
        elif sample is not None:
            self._fill(sample[0])  # the FIFO begins with the samples after the write that switched it on

    def read(self, length: int) -> bytes:
        """The bytes of a read message. Raises OSError (EREMOTEIO) if the device does not acknowledge."""
        self._acknowledge()
        self._latch()
        layout, garbage = self._layout, self._registers.failure == Failure.GARBAGE
        answer = bytearray()
        frees = False
        for _ in range(length):
            place = self._place(self._pointer)
            value = self._read_place(place)
            is_data = place in layout.data or (layout.fifo is not None and place == layout.fifo.window)
            answer.append(self._random() if garbage and is_data else value)
            frees |= place == layout.read_frees
            self._pointer = self._after(place)
        if frees:
            self._registers.set_read_counts(self._newest, self._newest, self._newest)
        return bytes(answer)

    def close(self) -> None:
        """Release the memory; may be called twice."""
        self._registers.close()

    def _place(self, register: int) -> int:
        bank_register = self._layout.bank_register
        if bank_register < 0 or register == bank_register:
            return register
        return (self._registers.buffer[bank_register] >> 4 & 3) * _BANK + register

    def _after(self, place: int) -> int:
        layout, fifo = self._layout, self._layout.fifo
        if fifo is not None and place == fifo.window and fifo.streaming:
            return self._pointer
        if (
            fifo is not None
            and fifo.rolls
            and self._next_in_fifo is not None
            and place == layout.data.stop - 1
        ):
            return layout.data.start
        return (self._pointer + self._increment) & 0x7F

    def _read_place(self, place: int) -> int:
        layout, fifo = self._layout, self._layout.fifo
        if fifo is not None and place == fifo.window and self._next_in_fifo is not None:
            if fifo.streaming:
                return self._pop_byte()
            self._pop_sample()
        value = self._registers.buffer[place]
        if place in layout.identity and self._registers.failure == Failure.WRONG_IDENTITY:
            return value ^ 0xFF
        return value

    def _latch(self) -> None:
        """Update data, status and FIFO counts to the newest sample, as at the start of a read."""
        layout, registers = self._layout, self._registers
        buffer = registers.buffer
        sample = registers.sample()
        if sample is None:
            return
        count, *counts = sample
        taken = registers.read_counts()[0]
        fresh = count > taken
        self._idle = 0 if fresh else self._idle + 1
        status = ChipStatus(fresh, count > taken + 1, self._fill(count), self._fifo_overrun)
        through_fifo = (
            layout.fifo is not None and not layout.fifo.streaming and self._next_in_fifo is not None
        )
        if layout.sensed.sensing(buffer) is not None and not through_fifo:
            buffer[layout.data.start : layout.data.stop] = layout.encode(
                buffer, (counts[0], counts[1], counts[2])
            )
        self._newest = count
        buffer[layout.status_register] = layout.status(buffer, status)
        if layout.fifo is not None:
            for register, value in layout.fifo.counts(status).items():
                buffer[register] = value

    def _fill(self, count: int) -> int:
        """Number of whole samples in the FIFO, after the newest have pushed out the oldest."""
        fifo = self._layout.fifo
        if fifo is None or not fifo.on(self._registers.buffer):
            return 0
        if self._next_in_fifo is None:
            self._next_in_fifo, self._byte_in_fifo = count + 1, 0
        self._fifo_overrun = count - self._next_in_fifo >= fifo.depth
        if self._fifo_overrun:
            self._next_in_fifo, self._byte_in_fifo = count - fifo.depth + 1, 0
        return count - self._next_in_fifo + 1

    def _pop_byte(self) -> int:
        first = self._next_in_fifo
        if first is None or first > self._newest:
            return 0
        fifo = self._layout.fifo
        encode = fifo.entry if fifo is not None and fifo.entry is not None else self._layout.encode
        entry = encode(self._registers.buffer, self._registers.past_sample(first))
        value = entry[self._byte_in_fifo]
        self._byte_in_fifo += 1
        if self._byte_in_fifo == len(entry):
            self._next_in_fifo, self._byte_in_fifo = first + 1, 0
        return value

    def _pop_sample(self) -> None:
        first, layout = self._next_in_fifo, self._layout
        if first is None or first > self._newest:
            return
        buffer = self._registers.buffer
        buffer[layout.data.start : layout.data.stop] = layout.encode(
            buffer, self._registers.past_sample(first)
        )
        self._next_in_fifo = first + 1

    def _acknowledge(self) -> None:
        if self._idle >= _LOOK_FOR_RESTART:
            self._idle = 0
            registers = reopened(self._registers, self._name)
            if registers is not self._registers:
                self._registers, self._next_in_fifo = registers, None
        try:
            raise_failure(self._registers.failure)
        except OSError:
            self._idle += 1
            self._next_in_fifo = None
            raise

    def _random(self) -> int:
        """A pseudo-random byte (Numerical Recipes' linear congruence), the same from run to run."""
        self._noise = (self._noise * 1664525 + 1013904223) & 0xFFFFFFFF
        return self._noise >> 24
