"""Reads status and data of an accelerometer in one I2C transfer, with prepared messages."""

from ctypes import POINTER, c_char, cast, create_string_buffer

import smbus2

from stillarm.drivers.accelerometers.register_tables.register_table import RegisterTable

_READ = 0x0001  # I2C_M_RD
# registers between status and data: up to this many, reading them costs less than a second address
_ONE_SPAN_GAP = 3


class StatusAndData:
    """The transfer. If status and data are far apart, it reads two spans, each after a repeated start."""

    def __init__(self, table: RegisterTable, address: int) -> None:
        """Prepare the messages; sends nothing."""
        gap = table.data_register - table.status_register
        together = 0 < gap <= _ONE_SPAN_GAP + 1
        spans = (
            [(table.status_register, gap + table.data_length)]
            if together
            else [(table.status_register, 1), (table.data_register, table.data_length)]
        )
        self._data_at = gap if together else 1
        self._buffer = create_string_buffer(self._data_at + table.data_length)
        self._messages = []
        self.bytes_on_bus = 0  # including the address byte of each message
        at = 0
        for register, length in spans:
            increment = table.auto_increment if length > 1 else 0
            self._messages.append(smbus2.i2c_msg.write(address, [register | increment]))
            place = cast((c_char * length).from_buffer(self._buffer, at), POINTER(c_char))
            self._messages.append(smbus2.i2c_msg(addr=address, flags=_READ, len=length, buf=place))
            at += length
            self.bytes_on_bus += 2 + 1 + length

    def read(self, bus: smbus2.SMBus) -> tuple[int, bytes]:
        """(status byte, data bytes). Raises OSError."""
        bus.i2c_rdwr(*self._messages)
        raw = self._buffer.raw
        return raw[0], raw[self._data_at :]
