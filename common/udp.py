"""A UDP socket that never blocks: send, and drain what has arrived, within a bound."""

import contextlib
import secrets
import socket

from common.datagram import MAX_DATAGRAM_BYTES
from common.user_error import UserError

Address = tuple[str, int]


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
        self.send_failures = 0

    def send(self, data: bytes, to: Address) -> None:
        """Send one datagram. A full queue or an absent peer loses it, as UDP may; that is counted."""
        try:
            self._socket.sendto(data, to)
        except OSError:
            self.send_failures += 1

    def drain(self, limit: int) -> list[bytes]:
        """Up to `limit` datagrams that have arrived, oldest first."""
        received: list[bytes] = []
        receive = self._socket.recv
        with contextlib.suppress(BlockingIOError):
            while len(received) < limit:
                try:
                    received.append(receive(MAX_DATAGRAM_BYTES + 1))
                except ConnectionError:  # a queued "port unreachable" from an earlier send
                    continue
        return received

    def drain_with_senders(self, limit: int) -> list[tuple[bytes, Address]]:
        """Up to `limit` datagrams that have arrived, oldest first, each with the address it came from."""
        received: list[tuple[bytes, Address]] = []
        with contextlib.suppress(BlockingIOError):
            while len(received) < limit:
                try:
                    received.append(self._socket.recvfrom(MAX_DATAGRAM_BYTES + 1))
                except ConnectionError:  # a queued "port unreachable" from an earlier send
                    continue
        return received

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
    """A random session number, 63 bits, never 0."""
    return secrets.randbits(63) | 1
