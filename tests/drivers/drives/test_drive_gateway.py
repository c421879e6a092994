"""The gateway's side: the dead-man timer above all."""

from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.common.datagrams.datagram import Datagram, Rejected, decode, encode
from stillarm.common.datagrams.messages import DriveInput, DriveState, Hello
from stillarm.drivers.drives.drive_gateway import DEAD_MAN_INPUT_S, DEAD_MAN_S, DriveGateway, GatewayStatus
from tests.reference.plain_datagram import DRIVE_COMMAND, DRIVE_INPUT, plain_datagram

KEY = b"a key of the tests' own"
SESSION, OWN = 7, 70


def command(velocity: object, sequence: int, session: int = SESSION, key: bytes = KEY) -> bytes:
    return plain_datagram(key, DRIVE_COMMAND, session, sequence, (velocity,), echo=OWN)


def state_of(gateway: DriveGateway) -> DriveState:
    told = decode(KEY, gateway.state_datagram(0.5, -0.125))
    assert not isinstance(told, Rejected) and isinstance(told.body, DriveState)
    return told.body


def test_holds_still_before_the_first_command() -> None:
    gateway = DriveGateway(KEY, OWN)
    assert gateway.velocity_command(0.0) == 0.0
    assert state_of(gateway) == DriveState(0.5, -0.125, GatewayStatus.IDLE, 0)


def test_follows_until_the_dead_man_timer_and_again_after() -> None:
    gateway = DriveGateway(KEY, OWN)
    assert gateway.receive(command(0.3, 1), 10.0)
    assert gateway.velocity_command(10.0) == 0.3
    assert gateway.velocity_command(10.0 + 0.99 * DEAD_MAN_S) == 0.3
    assert state_of(gateway) == DriveState(0.5, -0.125, GatewayStatus.FOLLOWING, 1)
    assert gateway.velocity_command(10.0 + 1.01 * DEAD_MAN_S) == 0.0
    assert state_of(gateway) == DriveState(0.5, -0.125, GatewayStatus.DEAD_MAN, 1)
    assert gateway.receive(command(-0.2, 2), 11.0)
    assert gateway.velocity_command(11.0) == -0.2


@pytest.mark.parametrize("velocity", [nan, inf, -inf, None, "fast", True, [0.1], b"\x00"])
def test_ignores_what_is_no_finite_number_and_does_not_rewind_the_timer(velocity: object) -> None:
    gateway = DriveGateway(KEY, OWN)
    gateway.receive(command(0.3, 1), 0.0)
    assert not gateway.receive(command(velocity, 2), 0.09)
    assert gateway.ignored + gateway.counts.malformed == 1
    assert gateway.ignored == (type(velocity) is float)
    assert gateway.velocity_command(0.09) == 0.3
    assert gateway.velocity_command(0.11) == 0.0


def test_refuses_forged_repeated_and_older_commands() -> None:
    gateway = DriveGateway(KEY, OWN)
    gateway.receive(command(0.1, 5), 0.0)
    for data in (command(0.5, 6, key=b"somebody else's key"), command(0.5, 5), command(0.5, 4)):
        assert not gateway.receive(data, 0.05)
    state = encode(KEY, SESSION, 9, DriveState(0.5, 0.5, 1, 1))
    assert not gateway.receive(state, 0.05)
    assert gateway.velocity_command(0.05) == 0.1
    counts = gateway.counts
    assert (counts.accepted, counts.forged, counts.duplicate, counts.unexpected) == (1, 1, 2, 1)


def test_a_replaced_session_has_no_say_any_more() -> None:
    gateway = DriveGateway(KEY, OWN)
    gateway.receive(command(0.1, 5, session=1), 0.0)
    assert gateway.receive(command(0.2, 1, session=2), 0.01)
    assert not gateway.receive(command(0.3, 6, session=1), 0.02)
    assert gateway.velocity_command(0.02) == 0.2


def test_state_counts_up_and_echoes_the_command() -> None:
    gateway = DriveGateway(KEY, session=OWN)
    gateway.receive(command(0.25, 41), 0.0)
    gateway.velocity_command(0.0)
    for sequence in (1, 2):
        state = decode(KEY, gateway.state_datagram(0.5, -0.125))
        assert state == (OWN, SESSION, sequence, DriveState(0.5, -0.125, GatewayStatus.FOLLOWING, 41))


@given(st.binary(max_size=1300))
def test_no_bytes_make_it_raise_or_move(data: bytes) -> None:
    gateway = DriveGateway(KEY, OWN)
    assert not gateway.receive(data, 0.0)
    assert gateway.velocity_command(0.0) == 0.0


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats() | st.text() | st.binary(),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    )
)
def test_no_signed_body_makes_it_raise_or_gives_a_velocity_that_is_no_number(body: object) -> None:
    gateway = DriveGateway(KEY, OWN)
    accepted = gateway.receive(command(body, 1), 0.0)
    assert accepted == (type(body) in (int, float) and -inf < body < inf)
    assert gateway.velocity_command(0.0) == (float(body) if accepted else 0.0)


def test_commands_of_another_life_of_the_gateway_are_not_followed_but_answered() -> None:
    """Old commands are replayed to a restarted gateway and not followed; a present commander learns its
    session and is followed.
    """
    yesterday = plain_datagram(KEY, DRIVE_COMMAND, SESSION, 5, (0.6,), echo=69)
    gateway = DriveGateway(KEY, OWN)
    assert not gateway.receive(yesterday, 0.0)
    hello = decode(KEY, gateway.hello() or b"")
    assert isinstance(hello, Datagram)
    assert (hello.body, hello.session, hello.echo) == (Hello(), OWN, SESSION)
    assert gateway.velocity_command(0.0) == 0.0
    assert gateway.receive(command(0.1, 1, session=8), 0.01)
    assert gateway.hello() is None
    assert not gateway.receive(yesterday, 0.02)
    assert gateway.velocity_command(0.02) == 0.1


def drive_input(value: object, sequence: int) -> bytes:
    return plain_datagram(KEY, DRIVE_INPUT, SESSION, sequence, (value,), echo=OWN)


def test_an_input_lapses_sooner_than_a_velocity() -> None:
    gateway = DriveGateway(KEY, OWN, DriveInput)
    assert gateway.input_command(0.0) is None
    assert gateway.receive(drive_input(3.5, 1), 10.0)
    assert gateway.input_command(10.0 + 0.99 * DEAD_MAN_INPUT_S) == 3.5
    assert gateway.input_command(10.0 + 1.01 * DEAD_MAN_INPUT_S) is None
    assert state_of(gateway) == DriveState(0.5, -0.125, GatewayStatus.DEAD_MAN, 1)


@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_an_input_that_is_no_finite_number_asks_to_brake_at_once(value: float) -> None:
    gateway = DriveGateway(KEY, OWN, DriveInput)
    gateway.receive(drive_input(3.5, 1), 10.0)
    assert gateway.receive(drive_input(value, 2), 10.001)
    assert gateway.input_command(10.001) is None
    assert gateway.receive(drive_input(-1.0, 3), 10.002)
    assert gateway.input_command(10.002) == -1.0


def test_a_gateway_refuses_what_its_drive_does_not_obey() -> None:
    of_inputs, of_velocities = DriveGateway(KEY, OWN, DriveInput), DriveGateway(KEY, OWN)
    assert not of_inputs.receive(command(0.3, 1), 0.0)
    assert not of_velocities.receive(drive_input(0.3, 1), 0.0)
    assert of_inputs.counts.unexpected == of_velocities.counts.unexpected == 1
    assert of_inputs.input_command(0.0) is None and of_velocities.velocity_command(0.0) == 0.0
