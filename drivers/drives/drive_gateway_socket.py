"""A drive gateway on a UDP port: commands in, the joint's state back to the commander."""

from stillarm.common.link.udp import Address, UdpSocket
from stillarm.drivers.drives.drive_gateway import DriveGateway

_MAX_DATAGRAMS = 64  # at once: a flood must not hold the gateway up
_EXPECTED_PER_LOOK = 4


class DriveGatewaySocket:
    """Feeds a DriveGateway from a socket; its answers go to the address of the last command that was accepted."""

    def __init__(self, gateway: DriveGateway, local: Address) -> None:
        """Bind to `local`. Raises UserError when that cannot be."""
        self._gateway = gateway
        self._socket = UdpSocket(local, "drive.gateway_port")
        self._socket.guard((gateway.takes,), gateway.session, _EXPECTED_PER_LOOK)
        self._commander: Address | None = None

    @property
    def address(self) -> Address:
        """Where the gateway listens."""
        return self._socket.address

    def poll(self, now_s: float) -> float:
        """Take what has arrived; returns the joint velocity to follow at `now_s`, rad/s."""
        self.take(now_s)
        return self._gateway.velocity_command(now_s)

    def take(self, now_s: float) -> None:
        """Take what has arrived."""
        for data, sender in self._socket.drain_with_senders(_MAX_DATAGRAMS):
            if self._gateway.receive(data, now_s):
                self._commander = sender
            elif answer := self._gateway.hello():
                self._socket.send(answer, sender)

    def report(self, position_rad: float, velocity_rad_s: float) -> None:
        """Send the joint's state to the commander; nothing before the first command."""
        if self._commander is not None:
            self._socket.send(self._gateway.state_datagram(position_rad, velocity_rad_s), self._commander)

    def close(self) -> None:
        """Release the port; may be called twice."""
        self._socket.close()
