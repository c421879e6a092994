"""Ports for processes that are started for a while."""

from stillarm.common.link.free_ports import free_ports
from stillarm.common.link.udp import UdpSocket


def test_free_ports_differ_and_can_be_bound() -> None:
    ports = free_ports(8)
    assert len(set(ports)) == 8
    sockets = [UdpSocket(("127.0.0.1", port), "test") for port in ports]
    for socket in sockets:
        socket.close()
