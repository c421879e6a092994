"""The controller's end of the drive link against the reference gateway, over loopback."""

import select
import socket
from collections.abc import Iterator
from math import inf, isnan, nan
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stillarm.common.datagrams.datagram import DEMO_KEY, encode
from stillarm.common.datagrams.messages import DriveCommand, DriveInput
from stillarm.common.files.configuration import DriveDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.drives.drive_factory import open_drive
from stillarm.drivers.drives.drive_gateway import DriveGateway, GatewayStatus
from stillarm.drivers.drives.drive_gateway_socket import DriveGatewaySocket
from stillarm.drivers.drives.udp_gateway_drive import UdpGatewayDrive, greet_gateway
from tests.reference.plain_datagram import DRIVE_STATE, plain_datagram

KEY = b"a key of the tests' own"
SESSION = 5


class Clock:
    """A clock that only moves when it is set."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


class Pair:
    """A drive and its gateway."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.gateway = DriveGateway(KEY)
        self.socket = DriveGatewaySocket(self.gateway, ("127.0.0.1", 0))
        self.config = DriveDevice(gateway_port=self.socket.address[1], local_port=0)  # 0: any free port
        self.drive = UdpGatewayDrive(self.config, KEY, clock=self.clock)
        self.drive.start()

    def join(self) -> None:
        """A command that does not know the gateway yet, and the answer that tells."""
        self.drive.command(0.0)
        self.arrived_at_gateway()
        assert self.socket.poll(0.0) == 0.0 and self.gateway.counts.unproven == 1
        self.arrived_at_drive()
        assert self.drive.state().age_s == inf

    def arrived_at_gateway(self) -> None:
        assert select.select([self.socket._socket.fileno()], [], [], 5.0)[0]

    def arrived_at_drive(self) -> None:
        assert self.drive._socket is not None
        assert select.select([self.drive._socket.fileno()], [], [], 5.0)[0]

    def drive_address(self) -> tuple[str, int]:
        assert self.drive._socket is not None
        return self.drive._socket.address

    def send_to_drive(self, data: bytes) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.sendto(data, self.drive_address())
        self.arrived_at_drive()


@pytest.fixture
def pair() -> Iterator[Pair]:
    pair = Pair()
    yield pair
    pair.drive.close()
    pair.socket.close()


def test_command_goes_out_and_state_comes_back(pair: Pair) -> None:
    pair.socket.report(9.0, 9.0)  # nobody to tell yet
    assert pair.drive.state().age_s == inf
    pair.join()
    pair.drive.command(0.25)
    pair.arrived_at_gateway()
    assert pair.socket.poll(0.0) == 0.25
    pair.socket.report(0.5, 0.125)
    pair.arrived_at_drive()
    assert pair.drive.state() == (0.5, 0.125, 0.0)
    assert (pair.drive.status, pair.drive.echoed_sequence) == (GatewayStatus.FOLLOWING, 2)
    pair.clock.now += 0.25
    assert pair.drive.state() == (0.5, 0.125, 0.25)


def test_answers_go_to_the_last_accepted_commander_only(pair: Pair) -> None:
    pair.join()
    pair.drive.command(0.25)
    pair.arrived_at_gateway()
    pair.socket.poll(0.0)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.bind(("127.0.0.1", 0))
        stranger.sendto(encode(b"the stranger's own key", 1, 1, DriveCommand(0.6)), pair.socket.address)
        pair.arrived_at_gateway()
        assert pair.socket.poll(0.01) == 0.25
    pair.socket.report(0.5, 0.0)
    pair.arrived_at_drive()
    assert pair.drive.state().position_rad == 0.5
    assert pair.gateway.counts.forged == 1


@pytest.mark.parametrize("velocity", [nan, inf, -inf])
def test_a_command_that_is_no_number_is_sent_as_zero(pair: Pair, velocity: float) -> None:
    pair.join()
    pair.drive.command(velocity)
    pair.arrived_at_gateway()
    assert pair.socket.poll(0.0) == 0.0
    assert pair.gateway.counts.accepted == 1
    assert pair.drive.refused == 1


def test_close_commands_zero(pair: Pair) -> None:
    pair.join()
    pair.drive.command(0.3)
    pair.drive.close()
    pair.drive.close()
    pair.arrived_at_gateway()
    assert pair.socket.poll(0.0) == 0.0
    assert pair.gateway.counts.accepted == 2
    with pytest.raises(RuntimeError, match="start"):
        pair.drive.command(0.1)


@pytest.mark.parametrize(
    "body",
    [
        (nan, 0.0, 1, 1),
        (0.0, inf, 1, 1),
        ("0.0", 0.0, 1, 1),
        (0.0, None, 1, 1),
        (0.0, True, 1, 1),
        (0.0, 0.0, 1.0, 1),
        (0.0, 0.0, 1, "1"),
    ],
)
def test_a_state_of_wrong_values_is_ignored_and_counted(pair: Pair, body: tuple[Any, ...]) -> None:
    pair.send_to_drive(plain_datagram(KEY, DRIVE_STATE, SESSION, 1, body, echo=pair.drive.session))
    state = pair.drive.state()
    assert isnan(state.position_rad)
    assert isnan(state.velocity_rad_s)
    assert state.age_s == inf
    finite_or_not = all(type(v) is float for v in body[:2]) and all(type(v) is int for v in body[2:])
    assert pair.drive.ignored == finite_or_not
    assert pair.drive.counts.malformed == (not finite_or_not)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=50)
@given(data=st.binary(min_size=1, max_size=1300))
def test_no_bytes_make_it_raise(pair: Pair, data: bytes) -> None:
    pair.send_to_drive(data)
    assert isnan(pair.drive.state().position_rad)


def test_commands_without_a_gateway_are_lost_quietly(pair: Pair) -> None:
    pair.socket.close()
    for _ in range(5):
        pair.drive.command(0.1)
        assert isnan(pair.drive.state().position_rad)


def test_factory() -> None:
    assert open_drive(DriveDevice(driver="none"), KEY) is None
    assert isinstance(open_drive(DriveDevice(), DEMO_KEY), UdpGatewayDrive)
    assert isinstance(open_drive(DriveDevice(gateway_host="192.0.2.7"), KEY), UdpGatewayDrive)
    with pytest.raises(UserError, match=r"^drive\.gateway_host = '192\.0\.2\.7' [^\n]*link\.key_file[^\n]*$"):
        open_drive(DriveDevice(gateway_host="192.0.2.7"), DEMO_KEY)


@pytest.mark.parametrize("takes", [DriveCommand, DriveInput])
@pytest.mark.parametrize("takes_inputs", [False, True])
def test_a_gateway_answers_who_asks_it_for_what_it_takes_and_obeys_nothing(
    takes: type[DriveCommand] | type[DriveInput], takes_inputs: bool
) -> None:
    """Where the model says otherwise of the drive, that is told."""
    gateway = DriveGateway(KEY, takes=takes)
    gateway_socket = DriveGatewaySocket(gateway, ("127.0.0.1", 0))
    clock = Clock()

    def sleep(seconds: float) -> None:
        clock.now += seconds
        gateway_socket.take(clock.now)

    config = DriveDevice(gateway_port=gateway_socket.address[1], local_port=0)

    def greet() -> int:
        return greet_gateway(config, KEY, 0.2, takes_inputs=takes_inputs, clock=clock, sleep=sleep).reports

    if takes_inputs == (takes is DriveInput):
        assert greet() > 0
    else:
        with pytest.raises(UserError, match="takes velocities" if takes_inputs else "takes inputs"):
            greet()
    assert gateway.counts.accepted == 0
    gateway_socket.close()
