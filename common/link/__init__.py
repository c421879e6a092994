"""The link between the computers: whose datagrams are taken, how they are signed, the peer's clock, and the socket.

Not here: what a datagram holds (common/datagrams), and what the controller and the supervisor make of it
(their exchange modules).
Begin with peer.py, then udp.py.
"""

__all__ = ["clock_offset", "free_ports", "link_key", "operator_sender", "peer", "udp"]
