"""A serial port for a loop that must not wait: reads what has arrived, writes what fits, detects its loss.

A name is a device (/dev/ttyACM0), a stable link (/dev/serial/by-id/...), or "pty:NAME": an emulator's pseudo terminal.
"""

import contextlib
import fcntl
import os
import termios
from array import array

import serial

from stillarm.common.memory.shared_memory import block_path
from stillarm.common.user_error import UserError

PTY_PREFIX = "pty:"
_READ_BYTES = 4096


def port_path(name: str) -> str:
    """The path of a port's name."""
    return str(block_path(f"{name.removeprefix(PTY_PREFIX)}.pty")) if name.startswith(PTY_PREFIX) else name


class PortLost(Exception):
    """The port is gone: unplugged, or its other end has closed."""


class SerialPort:
    """An open serial port, raw, 8N1, exclusive, never blocking."""

    def __init__(self, name: str, baud: int, key: str) -> None:
        """Open it. key: the configuration's key that named it, for the message. Raises UserError with a remedy."""
        self.name = name
        try:
            self._port = serial.Serial(port_path(name), baud, timeout=0, write_timeout=0, exclusive=True)
            self._descriptor: int = self._port.fileno()
            _tell_empty_from_gone(self._descriptor)
            os.set_blocking(self._descriptor, False)
        except (serial.SerialException, OSError, ValueError, termios.error) as error:
            raise UserError(f"{key} = {name!r}: {_remedy(name, error)}") from None
        self._arrived = array("i", [0])

    def read(self) -> bytes:
        """The bytes that have arrived, up to 4096; empty if there are none. Raises PortLost.

        Asks for their number first: a non-blocking read of an empty port still waits until the kernel's worker, which
        has no real-time priority, has handed over pending data. That took milliseconds.
        """
        try:
            fcntl.ioctl(self._descriptor, termios.FIONREAD, self._arrived, True)
            if not self._arrived[0]:
                return b""
            data = os.read(self._descriptor, _READ_BYTES)
        except BlockingIOError:
            return b""
        except OSError as error:
            raise PortLost(error.strerror or str(error)) from None
        if not data:
            raise PortLost("the other end has closed")
        return data

    def write(self, data: bytes) -> None:
        """Send what fits into the port's buffer; drop the rest. Raises PortLost."""
        try:
            os.write(self._descriptor, data)
        except BlockingIOError:
            return
        except OSError as error:
            raise PortLost(error.strerror or str(error)) from None

    def close(self) -> None:
        """Release the port; may be called twice."""
        with contextlib.suppress(OSError, serial.SerialException):
            self._port.close()


def _tell_empty_from_gone(descriptor: int) -> None:
    """Raise PortLost if the port hung up. With VMIN = 0, as pyserial sets it, a read does not show the difference."""
    attributes = termios.tcgetattr(descriptor)
    attributes[6][termios.VMIN] = 1
    termios.tcsetattr(descriptor, termios.TCSANOW, attributes)


def _remedy(name: str, error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number is None and error.args and isinstance(error.args[0], int):
        number = error.args[0]
    if number in (11, 16):
        return "in use by another process; stop that process (ModemManager grabs new ports: disable it)"
    if name.startswith(PTY_PREFIX):
        return (
            "no process offers this port; start it (the simulated rig: `stillarm rig`), or name a real port"
        )
    if number == 2:
        return "no such port; plug the device in, or name one of /dev/serial/by-id/*"
    if number == 13:
        return "permission denied; add this user to the group that owns it (usually dialout) and log in again"
    if number == 25 or "'inappropriate ioctl" in str(error).lower():
        return "not a serial port; name one of /dev/serial/by-id/*"
    return f"cannot be opened ({' '.join(str(error).lower().split())}); name a serial port"
