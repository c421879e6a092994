"""The gateway's side of the drive's datagrams, as docs/gateway.md describes them: the reference for a
gateway's maker.

Pure: bytes and times come in, bytes and velocities go out. The simulated rig runs it; so can a computer
beside a real drive.
"""

from enum import IntEnum
from math import isfinite, nan

from common.datagram import Kind, encode
from common.peer import LinkCounts, Peer
from common.udp import new_session

DEAD_MAN_S = 0.1


class GatewayStatus(IntEnum):
    """Third field of a DRIVE_STATE."""

    IDLE = 0  # no valid command so far
    FOLLOWING = 1
    DEAD_MAN = 2  # commands ceased: the joint is held at zero velocity


class DriveGateway:
    """Takes DRIVE_COMMANDs, gives the velocity to follow, and words the DRIVE_STATEs that answer them."""

    def __init__(self, key: bytes, session: int | None = None) -> None:
        """key: 16 to 32 bytes, shared with the controller. session: of the answers; None draws a random
        one."""
        self._key = key
        self.session = new_session() if session is None else session
        self._peer = Peer(key, (Kind.DRIVE_COMMAND,), self.session)
        self._sequence = 0
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
        velocity = datagram.body[0]
        if type(velocity) not in (float, int) or not isfinite(velocity):
            self.ignored += 1
            return False
        self._velocity = float(velocity)
        self._received_s = now_s
        self._command_sequence = datagram.sequence
        return True

    def velocity_command(self, now_s: float) -> float:
        """The joint velocity to follow at `now_s`, rad/s: zero when the last valid command is older than 0.1
        s."""
        if now_s - self._received_s <= DEAD_MAN_S:
            self._status = GatewayStatus.FOLLOWING
            return self._velocity
        if self._command_sequence:
            self._status = GatewayStatus.DEAD_MAN
        return 0.0

    def state_datagram(self, position_rad: float, velocity_rad_s: float) -> bytes:
        """A DRIVE_STATE of the joint's measured position and velocity, with the newest command's sequence
        number."""
        self._sequence += 1
        body = (position_rad, velocity_rad_s, int(self._status), self._command_sequence)
        return encode(
            self._key, Kind.DRIVE_STATE, self.session, self._sequence, body, echo=self._peer.session
        )

    def hello(self) -> bytes | None:
        """What to answer to the sender of the datagram that receive() has just refused, where it was well signed
        but did not echo this gateway's session: a HELLO that tells it. None where there is nothing to answer.
        """
        if not self._peer.greeting:
            return None
        self._sequence += 1
        return encode(self._key, Kind.HELLO, self.session, self._sequence, (), echo=self._peer.greeting)
