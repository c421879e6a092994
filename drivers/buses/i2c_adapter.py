"""The kernel's part of an emulated I2C bus: decodes the ioctl requests of /dev/i2c-N as the kernel would.

Sources: linux/uapi i2c-dev.h and i2c.h, and the kernel's emulation of SMBus transfers by I2C messages
(i2c_smbus_xfer_emulated): a register read is a write of the register's address and a read after a repeated start.
"""

import errno
import os
from ctypes import memmove, string_at
from typing import Any, Protocol

_I2C_SLAVE, _I2C_SLAVE_FORCE, _I2C_FUNCS, _I2C_RDWR, _I2C_PEC, _I2C_SMBUS = (
    0x703,
    0x706,
    0x705,
    0x707,
    0x708,
    0x720,
)
_MESSAGE_READ = 0x0001
_MAX_MESSAGES, _MAX_MESSAGE_BYTES = 42, 8192
_QUICK, _BYTE, _BYTE_DATA, _WORD_DATA, _PROC_CALL, _BLOCK_DATA, _I2C_BLOCK = 0, 1, 2, 3, 4, 5, 8
_BLOCK_MAX = 32
# plain I2C; SMBus quick, byte, byte data, word data, process call, block write, I2C block; no block read
FUNCTIONS = (
    0x0000_0001
    | 0x0001_0000
    | 0x0006_0000
    | 0x0018_0000
    | 0x0060_0000
    | 0x0080_0000
    | 0x0200_0000
    | 0x0C00_0000
)


class I2cDevice(Protocol):
    """A device on the bus: processes the bytes of messages. OSError (EREMOTEIO) means a missing acknowledge."""

    def write(self, data: bytes) -> None:
        """A write message's bytes."""

    def read(self, length: int) -> bytes:
        """A read message's answer, `length` bytes."""

    def close(self) -> None:
        """Release the device; may be called twice."""


class I2cAdapter:
    """One open bus with one device at one address."""

    def __init__(self, address: int, device: I2cDevice) -> None:
        """address: 7 bit."""
        self._address = address
        self._device = device
        self._selected = 0

    def ioctl(self, request: int, argument: Any) -> int:
        """Execute a request. argument: as smbus2 passes it to ioctl(). Raises OSError as the kernel would."""
        if request == _I2C_RDWR:
            return self._transfer(argument)
        if request == _I2C_SMBUS:
            self._smbus(argument)
        elif request in (_I2C_SLAVE, _I2C_SLAVE_FORCE):
            if argument > 0x7F:
                raise _error(errno.EINVAL)
            self._selected = argument
        elif request == _I2C_FUNCS:
            argument.value = FUNCTIONS
        elif request == _I2C_PEC:
            if argument:
                raise _error(errno.EOPNOTSUPP)
        else:
            raise _error(errno.ENOTTY)
        return 0

    def close(self) -> None:
        """Release the device; may be called twice."""
        self._device.close()

    def _transfer(self, argument: Any) -> int:
        count: int = argument.nmsgs
        if not 0 < count <= _MAX_MESSAGES:
            raise _error(errno.EINVAL)
        messages = argument.msgs
        for index in range(count):
            message = messages[index]
            length = message.len
            if length > _MAX_MESSAGE_BYTES:
                raise _error(errno.EINVAL)
            if message.addr != self._address:
                raise _error(errno.EREMOTEIO)
            if message.flags & _MESSAGE_READ:
                memmove(message.buf, self._device.read(length), length)
            else:
                self._device.write(string_at(message.buf, length))
        return count

    def _smbus(self, argument: Any) -> None:
        reads, command, size = bool(argument.read_write), int(argument.command), int(argument.size)
        if size not in (_QUICK, _BYTE, _BYTE_DATA, _WORD_DATA, _PROC_CALL, _BLOCK_DATA, _I2C_BLOCK) or (
            size == _BLOCK_DATA and reads
        ):
            raise _error(errno.EOPNOTSUPP)
        if self._selected != self._address:
            raise _error(errno.EREMOTEIO)
        device = self._device
        if size == _QUICK:
            device.write(b"")
            return
        if size == _BYTE:
            if reads:
                argument.data.contents.byte = device.read(1)[0]
            else:
                device.write(bytes((command,)))
            return
        data = argument.data.contents
        if size == _PROC_CALL:
            device.write(bytes((command,)) + data.word.to_bytes(2, "little"))
            data.word = int.from_bytes(device.read(2), "little")
        elif reads:
            device.write(bytes((command,)))
            self._smbus_read(size, data)
        else:
            device.write(bytes((command,)) + _smbus_payload(size, data))

    def _smbus_read(self, size: int, data: Any) -> None:
        if size == _BYTE_DATA:
            data.byte = self._device.read(1)[0]
        elif size == _WORD_DATA:
            data.word = int.from_bytes(self._device.read(2), "little")
        else:
            length = _block_length(data)
            data.block[1 : length + 1] = list(self._device.read(length))


def _smbus_payload(size: int, data: Any) -> bytes:
    """The bytes after the command byte that a write of `size` sends."""
    if size == _BYTE_DATA:
        return bytes((data.byte,))
    if size == _WORD_DATA:
        return bytes(data.word.to_bytes(2, "little"))
    length = _block_length(data)
    return bytes(data.block[0 if size == _BLOCK_DATA else 1 : length + 1])


def _block_length(data: Any) -> int:
    length = int(data.block[0])
    if not 0 < length <= _BLOCK_MAX:
        raise _error(errno.EINVAL)
    return length


def _error(number: int) -> OSError:
    return OSError(number, os.strerror(number))
