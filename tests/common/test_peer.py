"""Which datagrams of a peer are taken, against a plain model of it, and the counts."""

import msgspec
from hypothesis import given, settings
from hypothesis import strategies as st

from common.datagram import Kind, encode
from common.peer import Peer

KEY = b"0123456789abcdef"


def timestamp(session: int, sequence: int) -> bytes:
    return encode(KEY, Kind.TIMESTAMP, session, sequence, (sequence,))


def peer() -> Peer:
    return Peer(KEY, (Kind.TIMESTAMP,))


@settings(deadline=None)
@given(st.lists(st.integers(1, 700), min_size=1))
def test_one_session_against_a_plain_model(sequences: list[int]) -> None:
    taken, newest, seen = peer(), 0, set[int]()
    lost = late = duplicate = accepted = 0
    for sequence in sequences:
        got = taken.receive(timestamp(9, sequence))
        if not newest or sequence > newest:
            assert got is not None and got.sequence == sequence
            seen.update(range(1, sequence) if not newest else ())  # what came before the first is not missed
            lost += sequence - newest - 1 if newest else 0
            newest, accepted = sequence, accepted + 1
        else:
            assert got is None
            if sequence not in seen and newest - sequence < 256:
                late, lost = late + 1, lost - 1
            else:
                duplicate += 1
        seen.add(sequence)
    counts = taken.counts
    assert (counts.accepted, counts.lost, counts.late, counts.duplicate) == (accepted, lost, late, duplicate)
    assert counts.lost >= 0


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(1, 5), st.integers(1, 20))))
def test_a_replaced_session_is_never_taken_again(datagrams: list[tuple[int, int]]) -> None:
    taken, order = peer(), list[int]()
    for session, sequence in datagrams:
        if taken.receive(timestamp(session, sequence)) is not None and (not order or order[-1] != session):
            order.append(session)
    assert len(order) == len(set(order)) == taken.counts.sessions
    assert (
        sum(msgspec.structs.astuple(taken.counts))
        == len(datagrams) + taken.counts.sessions + taken.counts.lost
    )


def test_a_restarted_peer_is_taken_from_its_first_datagram() -> None:
    taken = peer()
    assert taken.receive(timestamp(1, 1000)) is not None
    assert taken.receive(timestamp(2, 1)) is not None
    assert taken.receive(timestamp(1, 1001)) is None
    assert taken.counts.old_session == 1 and taken.counts.sessions == 2 and taken.counts.lost == 0


def test_what_is_forged_malformed_or_of_another_kind_changes_nothing_but_a_count() -> None:
    taken = peer()
    taken.receive(timestamp(1, 1))
    forged = bytearray(timestamp(2, 50))
    forged[-1] ^= 1
    assert taken.receive(bytes(forged)) is None
    assert taken.receive(b"x") is None
    assert taken.receive(encode(KEY, Kind.REFERENCE, 3, 1, (0.0, True))) is None
    assert (taken.session, taken.sequence) == (1, 1)
    assert (taken.counts.forged, taken.counts.malformed, taken.counts.unexpected) == (1, 1, 1)
    assert taken.receive(timestamp(1, 2)) is not None
