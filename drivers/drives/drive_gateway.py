"""The gateway's side of the drive's datagrams, as docs/gateway.md describes them: the reference for a
gateway's maker.

Pure: bytes and times come in, bytes and velocities go out. The simulated rig runs it; so can a computer
beside a real drive.
"""

from enum import IntEnum
from math import isfinite, nan

from stillarm.common.datagrams.datagram import LinkCounts, Peer
from stillarm.common.datagrams.messages import DriveCommand, DriveInput, DriveState, Hello
from stillarm.common.link.udp import new_session

DEAD_MAN_S = 0.1
DEAD_MAN_INPUT_S = 0.02
"""A velocity may be held for longer than a torque, which goes on to accelerate."""


class GatewayStatus(IntEnum):
    """Third field of a DRIVE_STATE."""

    IDLE = 0  # no valid command so far
    FOLLOWING = 1
    DEAD_MAN = 2  # commands ceased: the joint is held at zero velocity, or braked


class DriveGateway:
    """Takes DRIVE_COMMANDs or DRIVE_INPUTs, gives the velocity or the input to follow, and words the DRIVE_STATEs that
    answer them."""

    def __init__(
        self,
        key: bytes,
        session: int | None = None,
        takes: type[DriveCommand] | type[DriveInput] = DriveCommand,
    ) -> None:
        """key: 16 to 32 bytes, shared with the controller. session: of the answers; None draws a random one. takes:
        what the drive obeys, velocities or inputs; the other is refused.
        """
        self.session = new_session() if session is None else session
        self.takes = takes
        self._dead_man_s = DEAD_MAN_S if takes is DriveCommand else DEAD_MAN_INPUT_S
        self._peer: Peer[DriveCommand | DriveInput] = Peer(key, (takes,), self.session)
        self._command = 0.0
        self._received_s = nan
        self._command_sequence = 0
        self._status = GatewayStatus.IDLE
        self.ignored = 0
        """Commands that were signed and in order, but whose value is not a finite number."""

    @property
    def counts(self) -> LinkCounts:
        """What became of the datagrams received."""
        return self._peer.counts

    def receive(self, data: bytes, now_s: float) -> bool:
        """Take a datagram that arrived at `now_s`; True when it is a valid, newest command. Never raises for
        any bytes.

        A velocity that is no finite number is ignored and does not rewind the dead-man timer; such an input is valid
        and ends it.
        """
        datagram = self._peer.receive(data)
        if datagram is None:
            return False
        body = datagram.body
        command = body.velocity_rad_s if isinstance(body, DriveCommand) else body.input
        if not isfinite(command) and isinstance(body, DriveCommand):
            self.ignored += 1
            return False
        self._command = command
        self._received_s = now_s if isfinite(command) else nan
        self._command_sequence = datagram.sequence
        return True

    def velocity_command(self, now_s: float) -> float:
        """The joint velocity to follow at `now_s`, rad/s: zero when the last valid command is older than 0.1 s."""
        command = self.input_command(now_s)
        return 0.0 if command is None else command

    def input_command(self, now_s: float) -> float | None:
        """The input to give the drive at `now_s`, in its unit; None when the last one is older than 0.02 s or was no
        finite number, or there was none: the joint is to be braked.
        """
        if now_s - self._received_s <= self._dead_man_s:
            self._status = GatewayStatus.FOLLOWING
            return self._command
        if self._command_sequence:
            self._status = GatewayStatus.DEAD_MAN
        return None

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
