"""The socket with its guard against a flood."""

import socket
from collections.abc import Iterator

import pytest

from stillarm.common.datagrams.datagram import DEMO_KEY, encode
from stillarm.common.datagrams.messages import MESSAGES, Hello
from stillarm.common.link.udp import UdpSocket, new_session
from tests.fixtures.flood import OWN, TAKES, body


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
