"""The kernel's program against a plain reading of the rule, in an interpreter of its own and in the kernel itself."""

import socket
from collections.abc import Iterator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.datagrams.datagram import DEMO_KEY, MAX_DATAGRAM_BYTES, Datagram, decode, encode
from stillarm.common.datagrams.messages import MESSAGES, Hello, Message, Visual
from stillarm.common.link.flood_filter import FloodGuard, Instruction, flood_program
from stillarm.common.link.udp import UdpSocket, new_session

OWN = new_session()
TAKES = (Visual, Hello)


def let_through(program: list[Instruction], data: bytes) -> bool:
    """Run a classic BPF program over a UDP packet; a load beyond its end drops it, as the kernel does."""
    packet, accumulator, at = bytes(8) + data, 0, 0
    while True:
        code, if_true, if_false, constant = program[at]
        at += 1
        if code == 0x06:
            return constant != 0
        if code == 0x80:
            accumulator = len(packet)
        elif code in {0x20, 0x28, 0x30}:
            size = {0x20: 4, 0x28: 2, 0x30: 1}[code]
            if constant + size > len(packet):
                return False
            accumulator = int.from_bytes(packet[constant : constant + size], "big")
        else:
            holds = {
                0x15: accumulator == constant,
                0x25: accumulator > constant,
                0x35: accumulator >= constant,
            }
            at += if_true if holds[code] else if_false


def body(message: type[Message]) -> Message:
    return message(*range(1, 1 + len(message.__struct_fields__)))


@given(
    st.sampled_from(MESSAGES), st.integers(1, 2**40), st.sampled_from([0, OWN, OWN + 1, OWN - (1 << 40), 5])
)
def test_what_a_peer_sends_passes_and_nothing_of_another_kind_or_session(
    message: type[Message], sequence: int, echo: int
) -> None:
    data = encode(DEMO_KEY, new_session(), sequence, body(message), echo=echo)
    assert let_through(flood_program(TAKES, OWN), data) == (message in TAKES and echo in {0, OWN})


@settings(max_examples=300)
@given(st.binary(max_size=1400))
def test_what_passes_has_the_beginning_of_a_datagram(data: bytes) -> None:
    if let_through(flood_program(TAKES, OWN), data):
        assert 22 <= len(data) <= MAX_DATAGRAM_BYTES
        assert data[:5] == b"\xdc\x00\x17\x02\x02" or data[:3] == b"\x95\x02\x06"


@given(st.integers(0, 120), st.binary(min_size=1, max_size=4))
def test_what_the_process_would_take_is_never_turned_away(at: int, change: bytes) -> None:
    data = bytearray(encode(DEMO_KEY, new_session(), 7, body(Visual), echo=OWN))
    data[at : at + len(change)] = change
    got = decode(DEMO_KEY, bytes(data))
    if isinstance(got, Datagram) and isinstance(got.body, TAKES) and got.echo == OWN:
        assert let_through(flood_program(TAKES, OWN), bytes(data))


@pytest.fixture
def pair() -> Iterator[tuple[UdpSocket, socket.socket]]:
    receiver = UdpSocket(("127.0.0.1", 0), "test")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.connect(receiver.address)
        yield receiver, sender
    receiver.close()


def test_a_flood_is_turned_away_in_the_kernel_and_the_peer_still_heard(
    pair: tuple[UdpSocket, socket.socket],
) -> None:
    """20 strangers' datagrams and one of the peer's before each look; a look takes 16 at the most."""
    receiver, sender = pair
    receiver.guard(TAKES, OWN, 2)
    good = encode(DEMO_KEY, new_session(), 1, Hello(), echo=OWN)
    forged = bytes(range(80))
    read, heard = [], []
    for _ in range(300):
        for _ in range(20):
            sender.send(forged)
        sender.send(good)
        got = receiver.drain(16)
        read.append(len(got))
        heard.append(good in got)
    assert receiver.shielded
    assert sum(read[60:]) == 240 and all(heard[60:])
    assert max(read) <= 16
    assert receiver.shed > 4000
    for _ in range(2100):
        sender.send(good)
        assert receiver.drain(16) == [good]
    assert not receiver.shielded
    sender.send(forged)
    assert receiver.drain(16) == [forged]  # in quiet times it is the process that counts it


def test_a_backlog_after_a_pause_is_no_flood() -> None:
    guard = FloodGuard(2)
    assert not guard.see(90)
    assert not any(guard.see(1) for _ in range(100))
    assert not guard.see(90)


def test_the_kernel_takes_every_program(pair: tuple[UdpSocket, socket.socket]) -> None:
    receiver, sender = pair
    for message in MESSAGES:
        receiver.guard((message,), OWN, 0)
        receiver._shield(True)
        data = encode(DEMO_KEY, new_session(), 3, body(message), echo=OWN)
        other = encode(DEMO_KEY, new_session(), 3, body(message), echo=OWN ^ 1)
        sender.send(other)
        sender.send(data)
        assert receiver._socket.recv(2000) == data
