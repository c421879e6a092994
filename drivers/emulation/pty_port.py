"""The device's end of an emulated serial port: a pseudo terminal whose other end has the name "pty:NAME"."""

import contextlib
import os
import tty
from pathlib import Path

from stillarm.common.user_error import UserError
from stillarm.drivers.buses.serial_port import PTY_PREFIX, port_path

_READ_BYTES = 4096


class PtyPort:
    """A pseudo terminal with a named link. Unread bytes are dropped, as on a wire."""

    def __init__(self, name: str, key: str) -> None:
        """Make the port `name`, "pty:NAME", replacing an existing link. key: for the message. Raises UserError."""
        if not name.startswith(PTY_PREFIX):
            raise UserError(f"{key} = {name!r}: an emulator needs a port of its own, such as 'pty:rig'")
        self._link = Path(port_path(name))
        self._device, self._held = os.openpty()
        # The slave end stays open here, since the device's end fails while nobody has opened the port.
        tty.setraw(self._held)
        os.set_blocking(self._device, False)
        self._target = os.ttyname(self._held)
        self._link.unlink(missing_ok=True)
        self._link.symlink_to(self._target)

    def read(self) -> bytes:
        """The bytes that the driver has written, up to 4096."""
        try:
            return os.read(self._device, _READ_BYTES)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> None:
        """Send bytes to the driver; those that do not fit are lost."""
        with contextlib.suppress(BlockingIOError):
            os.write(self._device, data)

    def close(self) -> None:
        """Hang up: the driver's end fails, as if the device were unplugged. May be called twice."""
        if self._device < 0:
            return
        with contextlib.suppress(OSError):
            if str(self._link.readlink()) == self._target:
                self._link.unlink(missing_ok=True)
        os.close(self._held)
        os.close(self._device)
        self._device = self._held = -1
