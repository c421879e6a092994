"""The operator's end: commands (arm, disarm, clear, stop), adjustments and references. Pure: bytes in, bytes out.

The controller takes them only from a sender that has heard from it: it answers the first one by a HELLO, and takes
those that follow.
"""

from stillarm.common.datagrams.datagram import Peer
from stillarm.common.datagrams.messages import Adjustment, Hello, OperatorCommand, Reference


class OperatorSender:
    """Packs what an operator sends, and learns the controller's session from its answers."""

    def __init__(self, key: bytes, session: int) -> None:
        """Sign with `key`; `session` from stillarm.common.link.udp.new_session(), never used before."""
        self._peer = Peer(key, (Hello,), session)

    @property
    def known(self) -> bool:
        """Whether the controller has answered: what is packed from now on is taken."""
        return self._peer.session != 0

    def take(self, datagrams: list[bytes]) -> None:
        """Read what the controller answered."""
        for data in datagrams:
            self._peer.receive(data)

    def command(self, bits: int) -> bytes:
        """The datagram of a command, bits of stillarm.controller.safety.table.Operator; a repeated one does no harm."""
        return self._peer.encode(OperatorCommand(int(bits)))

    def adjustment(self, method: str, added_damping_ratio: float) -> bytes:
        """The datagram of another method (empty: as it is) or gain (NaN: as it is); a repeated one does no harm."""
        return self._peer.encode(Adjustment(method, float(added_damping_ratio)))

    def reference(self, velocity_rad_s: float, damping_allowed: bool) -> bytes:
        """The datagram of a joint velocity reference; to be renewed well within 0.1 s."""
        return self._peer.encode(Reference(float(velocity_rad_s), damping_allowed))
