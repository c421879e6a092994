"""UDP ports of this machine that nothing uses."""

import socket


def free_ports(count: int) -> list[int]:
    """Different ones, free when this returns."""
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(count)]
    for held in sockets:
        held.bind(("127.0.0.1", 0))
    ports = [int(held.getsockname()[1]) for held in sockets]
    for held in sockets:
        held.close()
    return ports
