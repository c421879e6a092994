"""Reads an accelerometer's FIFO in blocks. For logging only: a block of N samples is N sample periods old."""

import time
from collections.abc import Callable

import smbus2

from stillarm.common.user_error import UserError
from stillarm.drivers.accelerometers.i2c_set_up import read_registers
from stillarm.drivers.accelerometers.register_tables.register_table import Counts, Fifo, RegisterTable

_MESSAGES_PER_TRANSFER = 42  # the kernel's limit
_BYTES_PER_TRANSFER = 4096


class I2cFifo:
    """The FIFO of one device on an open bus."""

    def __init__(
        self,
        bus: smbus2.SMBus,
        address: int,
        table: RegisterTable,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Accesses nothing yet. Raises UserError if the part has no FIFO."""
        if table.fifo is None:
            raise UserError(f"accelerometer.driver: the {table.name} has no FIFO; read it sample by sample")
        self._fifo: Fifo = table.fifo
        self._bus = bus
        self._address = address
        self._increment = table.auto_increment
        self._sleep = sleep

    def start(self) -> None:
        """Empty the FIFO and switch it on. Raises OSError."""
        self._write(start=True)
        self.read()

    def stop(self) -> None:
        """Switch the FIFO off. Raises OSError."""
        self._write(start=False)

    def read(self) -> list[Counts]:
        """The whole samples in the FIFO, oldest first, in counts. Raises OSError."""
        fifo = self._fifo
        held = read_registers(
            self._bus, self._address, fifo.count_register | self._increment, fifo.count_length
        )
        entries = min(fifo.entries(held), fifo.depth)
        if entries == 0:
            return []
        data = self._drain(entries)
        size = fifo.sample_length
        return [fifo.decode(data[at : at + size]) for at in self._beginnings(data)]

    def _beginnings(self, data: bytes) -> range:
        """Offsets of the samples. A FIFO with a marker starts at it, because an overrun may leave half a sample."""
        size, marker = self._fifo.sample_length, self._fifo.marker
        first = 0
        if marker is not None:
            axis = size // 3
            first = next((at for at in range(0, size, axis) if data[at + marker[0]] & marker[1]), 0)
        return range(first, len(data) - size + 1, size)

    def _drain(self, entries: int) -> bytes:
        fifo, address = self._fifo, self._address
        register = fifo.data_register | self._increment
        if fifo.rolling:
            each = _BYTES_PER_TRANSFER // fifo.sample_length
            lengths = [min(each, entries - at) * fifo.sample_length for at in range(0, entries, each)]
            return b"".join(read_registers(self._bus, address, register, length) for length in lengths)
        answers = [smbus2.i2c_msg.read(address, fifo.sample_length) for _ in range(entries)]
        pairs = _MESSAGES_PER_TRANSFER // 2
        for at in range(0, entries, pairs):
            messages = []
            for answer in answers[at : at + pairs]:
                messages += [smbus2.i2c_msg.write(address, [register]), answer]
            self._bus.i2c_rdwr(*messages)
        return b"".join(bytes(answer) for answer in answers)

    def _write(self, *, start: bool) -> None:
        for write in self._fifo.start if start else self._fifo.stop:
            self._bus.write_byte_data(self._address, write.register, write.value)
            if write.wait_s:
                self._sleep(write.wait_s)
