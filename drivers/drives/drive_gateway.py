"""The gateway's side of the drive's datagrams, as docs/gateway.md describes them: the reference for a
gateway's maker.

Pure: bytes and times come in, bytes and velocities go out. The simulated rig runs it; so can a computer
beside a real drive.
"""

from enum import IntEnum
from math import isfinite, nan

from stillarm.common.datagrams.datagram import LinkCounts, Peer
from stillarm.common.datagrams.messages import DriveCommand, DriveState, Hello
from stillarm.common.link.udp import new_session

DEAD_MAN_S = 0.1


class GatewayStatus(IntEnum):
    """Third field of a DRIVE_STATE."""

    IDLE = 0  # no valid command so far
    FOLLOWING = 1
    DEAD_MAN = 2  # commands ceased: the joint is held at zero velocity


class DriveGateway:
    """Takes DRIVE_COMMANDs, gives the velocity to follow, and words the DRIVE_STATEs that answer them."""

    def __init__(self, key: bytes, session: int | None = None) -> None:
        """key: 16 to 32 bytes, shared with the controller. session: of the answers; None draws a random one."""
        self.session = new_session() if session is None else session
        self._peer = Peer(key, (DriveCommand,), self.session)
        self._velocity = 0.0
        self._received_s = nan
        self._command_sequence = 0
        self._status = GatewayStatus.IDLE
        self.ignored = 0
        """Commands that were signed and in order, but whose velocity is not a finite number."""

    @property
    def counts(self) -> LinkCounts:
        """What became of the datagrams received."""
        return self._peer.counts

    def receive(self, data: bytes, now_s: float) -> bool:
        """Take a datagram that arrived at `now_s`; True when it is a valid, newest command. Never raises for
        any bytes.

        A command that is no finite number is ignored and does not rewind the dead-man timer.
        """
        datagram = self._peer.receive(data)
        if datagram is None:
            return False
        velocity = datagram.body.velocity_rad_s
        if not isfinite(velocity):
            self.ignored += 1
            return False
        self._velocity = velocity
        self._received_s = now_s
        self._command_sequence = datagram.sequence
        return True

    def velocity_command(self, now_s: float) -> float:
        """The joint velocity to follow at `now_s`, rad/s: zero when the last valid command is older than 0.1 s."""
        if now_s - self._received_s <= DEAD_MAN_S:
            self._status = GatewayStatus.FOLLOWING
            return self._velocity
        if self._command_sequence:
            self._status = GatewayStatus.DEAD_MAN
        return 0.0

    def state_datagram(self, position_rad: float, velocity_rad_s: float) -> bytes:
        """A DRIVE_STATE of the joint's measured position and velocity, with the newest command's sequence number."""
        return self._peer.encode(
            DriveState(position_rad, velocity_rad_s, int(self._status), self._command_sequence)
        )

    def hello(self) -> bytes | None:
        """What to answer to the sender of the datagram that receive() has just refused, where it was well signed
        but did not echo this gateway's session: a HELLO that tells it. None where there is nothing to answer.
        """
        greeting = self._peer.greeting
        return self._peer.encode(Hello(), echo=greeting) if greeting else None
