"""Emulated serial ports whose bytes are there when they were sent, so that no test depends on the kernel's worker."""

import fcntl
import termios
import time
from array import array

import pytest

from drivers.emulation.pty_port import PtyPort

_FULL_BYTES = 4095  # what a terminal holds
_GIVE_UP_S = 10.0


def waiting_bytes(descriptor: int) -> int:
    """Bytes that a read of the terminal would give now."""
    count = array("i", [0])
    fcntl.ioctl(descriptor, termios.FIONREAD, count, True)
    return count[0]


@pytest.fixture(autouse=True)
def handed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let PtyPort.write return when the bytes lie at the driver's end."""
    write = PtyPort.write

    def write_and_wait(port: PtyPort, data: bytes) -> None:
        expected = min(waiting_bytes(port._held) + len(data), _FULL_BYTES)
        write(port, data)
        give_up = time.monotonic() + _GIVE_UP_S
        while waiting_bytes(port._held) < expected and time.monotonic() < give_up:
            time.sleep(1e-5)

    monkeypatch.setattr(PtyPort, "write", write_and_wait)
