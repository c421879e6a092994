"""The kernel's program against a plain reading of the rule, in an interpreter of its own and in the kernel itself."""

from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.datagrams.datagram import DEMO_KEY, MAX_DATAGRAM_BYTES, Datagram, decode, encode
from stillarm.common.datagrams.messages import MESSAGES, Message, Visual
from stillarm.common.link.flood_filter import FloodGuard, Instruction, flood_program
from stillarm.common.link.udp import new_session
from tests.fixtures.flood import OWN, TAKES, body


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


def test_a_backlog_after_a_pause_is_no_flood() -> None:
    guard = FloodGuard(2)
    assert not guard.see(90)
    assert not any(guard.see(1) for _ in range(100))
    assert not guard.see(90)
