"""A UDP socket that never blocks: send, and drain what has arrived, within a bound."""

import contextlib
import ctypes
import secrets
import select
import socket
import struct
from collections.abc import Callable
from typing import TypeVar

from stillarm.common.datagrams.datagram import MAX_DATAGRAM_BYTES
from stillarm.common.datagrams.messages import Message
from stillarm.common.link.flood_filter import FloodGuard, flood_program, packed
from stillarm.common.user_error import UserError

Address = tuple[str, int]
_Received = TypeVar("_Received")

# Linux, asm-generic/socket.h; Python does not name them.
_SO_ATTACH_FILTER, _SO_DETACH_FILTER, _SO_MEMINFO = 26, 27, 55
_MEMINFO = struct.Struct("=9I")
_DROPS = 8


class UdpSocket:
    """A bound, non-blocking UDP socket."""

    def __init__(self, local: Address, purpose: str) -> None:
        """Bind to `local`; `purpose` names the configuration section in the error when that fails."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        try:
            self._socket.bind(local)
        except (OSError, OverflowError) as error:
            self._socket.close()
            reason = getattr(error, "strerror", None) or str(error)
            raise UserError(
                f"{purpose}: cannot listen on {local[0]}:{local[1]} ({reason.lower()}); "
                "stop the process that uses it, or choose another host or port"
            ) from None
        poll = select.poll()
        poll.register(self._socket, select.POLLIN)
        self._ready = poll.poll
        self.send_failures = 0
        self._guard: FloodGuard | None = None
        self._program = b""

    def guard(self, takes: tuple[type[Message], ...], session: int, expected_per_look: int) -> None:
        """From now on, in a flood, have the kernel turn away all but the messages `takes` that echo `session`, or none.

        expected_per_look: datagrams that peers send between two calls of drain(), at the most.
        """
        self._guard = FloodGuard(expected_per_look)
        self._program = packed(flood_program(takes, session))

    def send(self, data: bytes, to: Address) -> None:
        """Send one datagram. A full queue or an absent peer loses it, as UDP may; that is counted."""
        try:
            self._socket.sendto(data, to)
        except OSError:
            self.send_failures += 1

    def drain(self, limit: int) -> list[bytes]:
        """Up to `limit` datagrams that have arrived, oldest first."""
        return self._drained(self._socket.recv, limit)

    def drain_with_senders(self, limit: int) -> list[tuple[bytes, Address]]:
        """Up to `limit` datagrams that have arrived, oldest first, each with the address it came from."""
        return self._drained(self._socket.recvfrom, limit)

    def _drained(self, receive: Callable[[int], _Received], limit: int) -> list[_Received]:
        received: list[_Received] = []
        while len(received) < limit and self._ready(0):  # asking costs a third of an empty read, which raises
            try:
                received.append(receive(MAX_DATAGRAM_BYTES + 1))
            except BlockingIOError:  # a damaged datagram was announced, and dropped
                break
            except ConnectionError:  # a queued "port unreachable" from an earlier send
                continue
        if self._guard is not None and self._guard.see(len(received)):
            self._shield(self._guard.judge(self.shed))
        return received

    @property
    def shielded(self) -> bool:
        """Whether the kernel turns away what does not look like a peer's."""
        return self._guard is not None and self._guard.shielded

    @property
    def shed(self) -> int:
        """How many datagrams the kernel turned away, or had no room for, since the start (modulo 2^32)."""
        try:
            answer = self._socket.getsockopt(socket.SOL_SOCKET, _SO_MEMINFO, _MEMINFO.size)
        except OSError:  # not Linux, or closed
            return 0
        return int(_MEMINFO.unpack(answer)[_DROPS]) if len(answer) == _MEMINFO.size else 0

    def _shield(self, on: bool) -> None:
        """Attach or detach the program; where that is not possible, the bound of drain() alone has to do."""
        with contextlib.suppress(OSError):
            if not on:
                self._socket.setsockopt(socket.SOL_SOCKET, _SO_DETACH_FILTER, 0)
                return
            code = ctypes.create_string_buffer(self._program, len(self._program))
            header = struct.pack("@HP", len(self._program) // 8, ctypes.addressof(code))  # struct sock_fprog
            self._socket.setsockopt(socket.SOL_SOCKET, _SO_ATTACH_FILTER, header)

    def fileno(self) -> int:
        """The descriptor, for select()."""
        return self._socket.fileno()

    @property
    def address(self) -> Address:
        """Where this socket listens."""
        host, port = self._socket.getsockname()[:2]
        return str(host), int(port)

    def close(self) -> None:
        """Release the port; may be called twice."""
        self._socket.close()


def new_session() -> int:
    """A random session number, of 2^62 to 2^63 - 1: msgpack gives all of these nine bytes, the kernel's filter
    counts on it.
    """
    return secrets.randbits(62) | 1 << 62
