"""Which datagrams of a peer are taken, against a plain model of it, and the counts."""

import msgspec
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.datagrams.datagram import Peer, encode
from stillarm.common.datagrams.messages import Reference, Timestamp

KEY = b"0123456789abcdef"


def timestamp(session: int, sequence: int, echo: int = 0) -> bytes:
    return encode(KEY, session, sequence, Timestamp(sequence, 0.5), echo=echo)


def peer() -> Peer[Timestamp]:
    return Peer(KEY, (Timestamp,))


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
    assert taken.receive(encode(KEY, 3, 1, Reference(0.0, True))) is None
    assert (taken.session, taken.sequence) == (1, 1)
    assert (taken.counts.forged, taken.counts.malformed, taken.counts.unexpected) == (1, 1, 1)
    assert taken.receive(timestamp(1, 2)) is not None


OWN = 77


def test_a_session_without_an_echo_of_ones_own_is_not_taken() -> None:
    taken = Peer(KEY, (Timestamp,), OWN)
    for echo in (0, 76):
        assert taken.receive(timestamp(1, 5, echo)) is None
        assert taken.greeting == 1
    assert (taken.session, taken.counts.unproven, taken.counts.accepted) == (0, 2, 0)
    assert taken.receive(timestamp(1, 6, OWN)) is not None
    assert taken.greeting == 0 and taken.session == 1


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(1, 4), st.integers(1, 9), st.sampled_from([0, 50, 60])), max_size=30))
def test_whatever_was_recorded_before_a_start_changes_nothing(played: list[tuple[int, int, int]]) -> None:
    """Datagrams of any session that echo no session or a former one do not disturb the present link."""
    taken = Peer(KEY, (Timestamp,), OWN)
    taken.receive(timestamp(9, 1, OWN))
    for sequence, datagram in enumerate(played, start=2):
        assert taken.receive(timestamp(*datagram)) is None
        assert taken.echo == 9
        assert taken.receive(timestamp(9, sequence, OWN)) is not None
    assert taken.counts.sessions == 1 and taken.counts.unproven == len(played)


class End:
    """One end of a link: says what it echoes, hears the other."""

    def __init__(self, session: int) -> None:
        self.session = session
        self.peer = Peer(KEY, (Timestamp,), session)

    def say(self) -> bytes:
        return self.peer.encode(Timestamp(5, 0.5))


@settings(deadline=None)
@given(st.data())
def test_two_ends_find_each_other_again_after_any_restarts(data: st.DataObject) -> None:
    """Losses, restarts of either, and a recording of everything so far played back in between: three undisturbed
    datagrams each way later both take each other.
    """
    left, right, fresh, played = End(1), End(2), 3, list[bytes]()
    for _ in range(data.draw(st.integers(0, 15))):
        what = data.draw(st.sampled_from(["left", "right", "restart left", "restart right", "play"]))
        if what == "left":
            played.append(left.say())
            right.peer.receive(played[-1])
        elif what == "right":
            played.append(right.say())
            left.peer.receive(played[-1])
        elif what == "restart left":
            left, fresh = End(fresh), fresh + 1
        elif what == "restart right":
            right, fresh = End(fresh), fresh + 1
        elif played:
            one = data.draw(st.sampled_from(played))
            left.peer.receive(one)
            right.peer.receive(one)
    for _ in range(3):
        right.peer.receive(left.say())
        left.peer.receive(right.say())
    assert left.peer.session == right.session and right.peer.session == left.session
    before = (left.peer.sequence, right.peer.sequence, left.peer.session, right.peer.session)
    for one in played:
        assert left.peer.receive(one) is None and right.peer.receive(one) is None
    assert before == (left.peer.sequence, right.peer.sequence, left.peer.session, right.peer.session)


def test_a_peer_that_restarts_without_end_is_refused_rather_than_remembered() -> None:
    taken = Peer(KEY, (Timestamp,), OWN)
    for session in range(1000, 1000 + Peer.MOST_SESSIONS + 2):
        taken.receive(timestamp(session, 1, OWN))
    assert taken.counts.sessions == Peer.MOST_SESSIONS + 1
    assert taken.counts.old_session == 1
    assert taken.receive(timestamp(taken.session, 2, OWN)) is not None
