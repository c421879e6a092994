"""The link between the computers: the socket, its filter against floods, the key, and the peer's clock.

Not here: what a datagram holds and whose are taken (common/datagrams), and what controller and supervisor
make of it (their exchange modules).
Begin with udp.py.
"""

__all__ = ["clock_offset", "free_ports", "link_key", "operator_sender", "udp"]
