"""An emulated MCP4725: its bus side, and the amplifier's view of it, in memory shared by the rig and the driver.

Layout of the block's payload: at 0 one word, written whole by the bus side: writes so far << 16 | power down << 12 |
code; at 8 the EEPROM's code; at 10 whether it refuses to acknowledge; at PART_AT the number that identifies the part.
Source: datasheet DS22039D: fast mode, DAC register, DAC register and EEPROM; a read of five bytes.
"""

import errno
import struct

from stillarm.common.memory.shared_memory import SharedBlock, word_at
from stillarm.drivers.emulated_chips.shared_registers import PART_AT

MCP4725_PART = 0x47
MCP4725_ADDRESS = 0x62
_EEPROM_AT, _NAK_AT, _SIZE = 8, 10, 1024
_EEPROM = struct.Struct("<H")


class Mcp4725Output:
    """The amplifier's view. The rig makes it and follows the voltage."""

    def __init__(self, name: str, power_up_code: int = 2048) -> None:
        """Make the DAC `name` (for the bus "memory:NAME"), with its power-up code at the output."""
        self._block = SharedBlock(name, _SIZE, create=True)
        self._word = word_at(self._block.buffer, 0)
        self._word[0] = power_up_code
        _EEPROM.pack_into(self._block.buffer, _EEPROM_AT, power_up_code)
        self._block.buffer[PART_AT] = MCP4725_PART

    def output(self) -> tuple[int, int | None]:
        """Number of writes, and the output code; None while the output is powered down."""
        word = self._word[0]
        return word >> 16, None if word >> 12 & 3 else word & 0xFFF

    def unplug(self, away: bool) -> None:
        """Set whether the DAC stops acknowledging."""
        self._block.buffer[_NAK_AT] = away

    def close(self) -> None:
        """Remove the DAC; may be called twice."""
        if not self._block.path.exists():
            return
        self._word.release()
        self._block.close()


class Mcp4725Chip:
    """The bus side; stillarm.drivers.buses.i2c_adapter.I2cDevice."""

    def __init__(self, name: str) -> None:
        """Open the DAC `name` that a rig made. Raises UserError if there is none."""
        self._block = SharedBlock(name, create=False)
        self._word = word_at(self._block.buffer, 0)

    def write(self, data: bytes) -> None:
        """A write message: fast mode (two bytes), or the register, or register and EEPROM (three bytes)."""
        self._acknowledge()
        if len(data) >= 2 and data[0] >> 6 == 0:
            self._set(data[-2] >> 4 & 3, (data[-2] & 0x0F) << 8 | data[-1])
        elif len(data) >= 3 and data[0] >> 5 in (2, 3):
            code = data[1] << 4 | data[2] >> 4
            self._set(data[0] >> 1 & 3, code)
            if data[0] >> 5 == 3:
                _EEPROM.pack_into(self._block.buffer, _EEPROM_AT, code)

    def read(self, length: int) -> bytes:
        """A read message's answer: status, code, EEPROM."""
        self._acknowledge()
        word = self._word[0]
        code, down = word & 0xFFF, word >> 12 & 3
        (kept,) = _EEPROM.unpack_from(self._block.buffer, _EEPROM_AT)
        answer = bytes((0xC0 | down << 1, code >> 4, code << 4 & 0xF0, kept >> 8, kept & 0xFF))
        return (answer * (length // 5 + 1))[:length]

    def close(self) -> None:
        """Release the memory; may be called twice."""
        self._word.release()
        self._block.close()

    def _set(self, power_down: int, code: int) -> None:
        writes = (self._word[0] >> 16) + 1 & 0xFFFF_FFFF_FFFF
        self._word[0] = writes << 16 | power_down << 12 | code

    def _acknowledge(self) -> None:
        if self._block.buffer[_NAK_AT]:
            raise OSError(errno.EREMOTEIO, "Remote I/O error")
