"""A drive behind a gateway that speaks the signed datagrams of docs/gateway.md over UDP.

A gateway of a drive that obeys a torque, a current or a voltage takes that in place of a velocity, from a velocity loop
on this side.
"""

import time
from collections.abc import Callable
from math import inf, isfinite, nan

from stillarm.common.datagrams.datagram import LinkCounts, Peer
from stillarm.common.datagrams.messages import DriveCommand, DriveInput, DriveState, Hello, Message
from stillarm.common.files.configuration import DriveDevice
from stillarm.common.link.udp import UdpSocket, new_session
from stillarm.common.user_error import UserError
from stillarm.drivers.drives.drive import DriveProbe, JointState
from stillarm.drivers.drives.velocity_loop import VelocityLoop

_MAX_DATAGRAMS = 32
_TAKES = (DriveState, Hello)
_ASK_EVERY_S = 0.02  # of a gateway that is only asked
_EXPECTED_PER_CYCLE = 3  # a gateway reports about once a millisecond


class UdpGatewayDrive:
    """Commands a joint's velocity and hears its state; implements stillarm.drivers.drives.drive.Drive."""

    def __init__(
        self,
        config: DriveDevice,
        key: bytes,
        *,
        loop: VelocityLoop | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Opens nothing. loop: where the gateway takes inputs. It acts on what state() returned last: both are called
        once a cycle, state() first. clock: seconds, never backwards.
        """
        self._config = config
        self._gateway = (config.gateway_host, config.gateway_port)
        self._clock = clock
        self.session = new_session()
        self._peer = Peer(key, _TAKES, self.session)
        self._socket: UdpSocket | None = None
        self._loop = loop
        self._position = self._velocity = nan
        self._arrived_s = -inf
        self._seen = JointState(nan, nan, inf)
        self.status = 0
        """The gateway's status: stillarm.drivers.drives.drive_gateway.GatewayStatus."""
        self.echoed_sequence = 0
        """Sequence number of the newest command that the gateway had when it reported."""
        self.ignored = 0
        """States that were signed and in order, but whose position or velocity is not a finite number."""
        self.refused = 0
        """Commands that were no finite number; zero was sent in their place."""

    @property
    def counts(self) -> LinkCounts:
        """What became of the datagrams received."""
        return self._peer.counts

    @property
    def tripped(self) -> bool:
        """Whether the velocity loop has given the joint up as run away."""
        return self._loop is not None and self._loop.tripped

    @property
    def shed(self) -> int:
        """Datagrams that the kernel turned away in a flood, or had no room for."""
        return self._socket.shed if self._socket is not None else 0

    @property
    def send_failures(self) -> int:
        """Commands that could not be sent."""
        return self._socket.send_failures if self._socket is not None else 0

    def start(self) -> None:
        """Open the socket. Moves nothing. Raises UserError when the port is taken."""
        self.close()
        if self._loop is not None:
            self._loop.reset()
        self._socket = UdpSocket((self._config.local_host, self._config.local_port), "drive.local_port")
        self._socket.guard(_TAKES, self.session, _EXPECTED_PER_CYCLE)

    def command(self, velocity_rad_s: float) -> None:
        """Send the joint velocity command, rad/s, or the input that the loop answers it with; what is no finite number
        is taken for zero, and counted.

        The gateway stops the joint when no command reaches it for 0.1 s, no input for 0.02 s. Raises RuntimeError
        before start().
        """
        if self._socket is None:
            raise RuntimeError("command() before start()")
        if not isfinite(velocity_rad_s):
            self.refused += 1
            velocity_rad_s = 0.0
        # float(): a NumPy scalar would not go into msgpack
        if self._loop is None:
            body: Message = DriveCommand(float(velocity_rad_s))
        else:
            body = DriveInput(float(self._loop.input_for(velocity_rad_s, self._seen)))
        self._socket.send(self._peer.encode(body), self._gateway)

    def state(self) -> JointState:
        """The newest report of the drive; never blocks. Before the first: NaN, NaN and an infinite age, which is
        infinite, too, once the loop has tripped."""
        if self._socket is None:
            raise RuntimeError("state() before start()")
        for data in self._socket.drain(_MAX_DATAGRAMS):
            datagram = self._peer.receive(data)
            if datagram is not None and isinstance(datagram.body, DriveState):
                self._take(datagram.body)
        age_s = inf if self.tripped else self._clock() - self._arrived_s
        self._seen = JointState(self._position, self._velocity, age_s)
        return self._seen

    def close(self) -> None:
        """Command zero and release the socket; may be called twice."""
        if self._socket is not None:
            last = DriveCommand(0.0) if self._loop is None else DriveInput(nan)  # stand still, or brake
            self._socket.send(self._peer.encode(last), self._gateway)
            self._socket.close()
            self._socket = None

    def _take(self, state: DriveState) -> None:
        if not (isfinite(state.position_rad) and isfinite(state.velocity_rad_s)):
            self.ignored += 1
            return
        self._position, self._velocity = state.position_rad, state.velocity_rad_s
        self.status, self.echoed_sequence = state.status, state.command_sequence
        self._arrived_s = self._clock()


def greet_gateway(
    config: DriveDevice,
    key: bytes,
    span_s: float,
    *,
    takes_inputs: bool = False,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> DriveProbe:
    """Ask a gateway for its identity with commands of zero that do not echo its session: it answers and obeys none.

    takes_inputs: whether the model says that the drive obeys inputs. Raises UserError if the gateway does not answer,
    if it takes the other kind of command, or if the port is in use (a controller runs).
    """
    socket = UdpSocket((config.local_host, config.local_port), "drive.local_port")
    gateway = (config.gateway_host, config.gateway_port)
    place = f"{config.gateway_host}:{config.gateway_port}"

    def answers_to(body: Message) -> tuple[int, int]:
        """How many answers within the span, and how many of another signature."""
        peer = Peer(key, _TAKES, new_session())
        answers, until = 0, clock() + span_s
        while clock() < until:
            socket.send(peer.encode(body, echo=0), gateway)
            sleep(_ASK_EVERY_S)
            answers += sum(peer.receive(data) is not None for data in socket.drain(_MAX_DATAGRAMS))
        return answers, peer.counts.forged

    velocity, drive_input = DriveCommand(0.0), DriveInput(0.0)
    try:
        heard, forged = answers_to(drive_input if takes_inputs else velocity)
        others = 0 if heard else answers_to(velocity if takes_inputs else drive_input)[0]
    finally:
        socket.close()
    if others:
        taken, kinds = (
            ("velocities", '"velocity"') if takes_inputs else ("inputs", '"torque", "current" or "voltage"')
        )
        raise UserError(
            f"drive.gateway_port = {config.gateway_port}: the gateway at {place} takes {taken}, which the model's "
            f"drive.kind does not say; set it to {kinds}, or the gateway to what the drive obeys"
        )
    if forged and not heard:
        raise UserError(
            f"drive.gateway_host: {place} answers with another signature: the keys differ; copy one link.key_file to "
            "controller and gateway"
        )
    if not heard:
        raise UserError(
            f"drive.gateway_port = {config.gateway_port}: no gateway answers at {place}; check its power and cable, "
            "start it (the simulated rig: `stillarm rig`), give it the same key, or correct drive.gateway_host and "
            "gateway_port"
        )
    return DriveProbe(f"gateway at {place}", heard, span_s, nan)
