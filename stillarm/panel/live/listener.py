"""The socket that telemetry comes to; it hands datagrams on and never answers."""

import asyncio
import socket
from collections.abc import Callable
from ipaddress import ip_address

from stillarm.common.user_error import UserError

_BUFFER_BYTES = 4 << 20  # telemetry of several seconds, should the server be busy


class _Protocol(asyncio.DatagramProtocol):
    def __init__(self, take: Callable[[bytes], None]) -> None:
        self._take = take

    def datagram_received(self, data: bytes, addr: object) -> None:
        """A datagram has arrived."""
        self._take(data)


async def listen(host: str, port: int, take: Callable[[bytes], None]) -> asyncio.DatagramTransport:
    """Hand each datagram that comes to host:port to `take`. Raises UserError where the port is another's.

    A multicast address joins its group.
    """
    listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
        if ip_address(host).is_multicast:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.setsockopt(
                socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(host) + b"\0\0\0\0"
            )
        listener.bind((host, port))
    except (OSError, ValueError) as error:
        listener.close()
        raise UserError(
            f"telemetry.panel_port: cannot listen on {host}:{port} ({getattr(error, 'strerror', None) or error}); "
            "stop the other panel, or choose another telemetry.host or panel_port"
        ) from None
    transport, _ = await asyncio.get_running_loop().create_datagram_endpoint(
        lambda: _Protocol(take), sock=listener
    )
    return transport
