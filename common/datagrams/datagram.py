"""Datagrams: a message of common/datagrams/messages.py with its head, packed and signed, and taken or refused.
docs/protocol.md describes them.

A datagram is a msgpack array [version, kind, session, echo, sequence, body...] followed by a 16-byte keyed BLAKE2s
tag of all bytes before it. Sessions are random numbers, drawn when a process starts; echo is the session of whom it is
meant for, as far as it is known; sequences count up from 1. `decode` checks what a datagram shows by itself, a `Peer`
what follows from those before it.

A session proves itself by echoing this side's own session, which is random and drawn anew at each start: only a sender
that has heard from this very process can echo and sign it. A datagram recorded before this process started is therefore
never taken. One recorded since is taken only if it is newer than the newest.
"""

import hmac
from functools import lru_cache
from hashlib import blake2s
from typing import Annotated, Any, Generic, Literal, NamedTuple, TypeVar, get_type_hints

import msgspec
from msgspec import Meta

from stillarm.common.datagrams.messages import MESSAGES, VERSION, Message

TAG_BYTES = 16
MAX_DATAGRAM_BYTES = 1200
DEMO_KEY = b"stillarm demo key, loopback only"
HEAD: dict[str, Any] = {
    "version": Literal[VERSION],
    "kind": int,
    "session": Annotated[int, Meta(ge=1)],
    "echo": Annotated[int, Meta(ge=0)],
    "sequence": Annotated[int, Meta(ge=1)],
}
"""What each datagram begins with."""
MIN_DATAGRAM_BYTES = 1 + len(HEAD) + TAG_BYTES
Body = TypeVar("Body", bound=Message)


class Datagram(NamedTuple, Generic[Body]):
    """A datagram whose tag held and whose message is as the table says.

    echo: the session of the receiver, as the sender knows it; 0 where it knows none.
    """

    session: int
    echo: int
    sequence: int
    body: Body


class Rejected(NamedTuple):
    """Why a datagram was not accepted: 'malformed', 'forged' or 'foreign_version'."""

    reason: str


def kind_of(message: type[Message]) -> int:
    """The number of a kind of message."""
    tag = message.__struct_config__.tag
    assert isinstance(tag, int)
    return tag


class _Start(msgspec.Struct, array_like=True, gc=False):
    """The first two fields of any array: the version tells whether the rest can be read."""

    version: Any
    kind: Any = None


_KINDS = {message: kind_of(message) for message in MESSAGES}
_DECODERS = {
    kind: (message, msgspec.msgpack.Decoder(tuple[(*HEAD.values(), *types.values())]))  # type: ignore[misc]
    for message, kind in _KINDS.items()
    for types in [get_type_hints(message, include_extras=True)]
}
_START = msgspec.msgpack.Decoder(_Start)
_ENCODE = msgspec.msgpack.Encoder().encode


def encode(key: bytes, session: int, sequence: int, body: Message, *, echo: int = 0) -> bytes:
    """A datagram ready to send. `key` has 16 to 32 bytes; a Peer knows the rest."""
    payload = _ENCODE((VERSION, _KINDS[type(body)], session, echo, sequence, *msgspec.structs.astuple(body)))
    return payload + _tag(key, payload)


def decode(key: bytes, data: bytes) -> Datagram[Message] | Rejected:
    """Check and read a datagram: size, then tag, then version, then all else. Never raises for any bytes."""
    if not MIN_DATAGRAM_BYTES <= len(data) <= MAX_DATAGRAM_BYTES:
        return Rejected("malformed")
    payload = data[:-TAG_BYTES]
    if not hmac.compare_digest(_tag(key, payload), data[-TAG_BYTES:]):
        return Rejected("forged")
    try:
        start = _START.decode(payload)
        if type(start.version) is not int or start.version != VERSION:  # True and 2.0 are no 2
            return Rejected("foreign_version")
        message, decoder = _DECODERS[start.kind]
        _, _, session, echo, sequence, *fields = decoder.decode(payload)
    except (msgspec.DecodeError, KeyError, TypeError, UnicodeDecodeError, RecursionError):
        return Rejected("malformed")
    return Datagram(session, echo, sequence, message(*fields))


def _tag(key: bytes, payload: bytes) -> bytes:
    tag = _keyed(key).copy()  # keying anew costs as much as the rest
    tag.update(payload)
    return tag.digest()


@lru_cache(maxsize=16)
def _keyed(key: bytes) -> blake2s:
    return blake2s(key=key, digest_size=TAG_BYTES)


class LinkCounts(msgspec.Struct):
    """Counts since the start. `lost` is the net number of sequence numbers never seen.

    unproven: well signed, but without an echo of this side's session: from a peer that does not know it yet, or played
    back. unexpected: well-formed, but of a kind that this socket does not take. overdue: its content is too old.
    """

    accepted: int = 0
    lost: int = 0
    duplicate: int = 0
    late: int = 0
    malformed: int = 0
    forged: int = 0
    foreign_version: int = 0
    old_session: int = 0
    unexpected: int = 0
    sessions: int = 0
    unproven: int = 0
    overdue: int = 0

    @property
    def refused(self) -> int:
        """Datagrams that were not taken for any reason but their order."""
        return (
            self.malformed
            + self.forged
            + self.foreign_version
            + self.old_session
            + self.unexpected
            + self.unproven
        )


class Peer(Generic[Body]):
    """Accepts the datagrams of one peer, in order, across its restarts, and packs those for it. Pure: no socket.

    A session that has been replaced is never accepted again. State moves on only after the tag holds.
    """

    MOST_SESSIONS = 4096
    """A peer that restarted more often is refused until this side restarts too: what is remembered stays
    bounded."""
    _REORDER_WINDOW = 256  # how far back a late datagram can be told from a duplicate

    def __init__(self, key: bytes, takes: tuple[type[Body], ...], own_session: int = 0) -> None:
        """Take the messages `takes` signed with `key`.

        own_session: that of this side, which a peer must echo; 0 asks for no proof (of what can do no harm).
        """
        self._key = key
        self._takes = takes
        self._own = own_session
        self._sent = 0
        self.session = 0
        self.sequence = 0
        self._heard = 0
        self._seen = 0  # bit k: sequence - k has been seen
        self._old: set[int] = set()
        self.greeting = 0
        """Session of the last datagram if that was well signed but proved nothing, else 0: it can be answered."""
        self.counts = LinkCounts()

    @property
    def echo(self) -> int:
        """What to echo: the session that is taken; until there is one, that last heard of; 0 before that."""
        return self.session or self._heard

    def expect(self, session: int) -> None:
        """Echo `session` from the start, where it is known before anything was heard."""
        self._heard = session

    def encode(self, body: Message, *, echo: int | None = None) -> bytes:
        """The next datagram of this side's session; echo: None for the peer's."""
        self._sent += 1
        return encode(self._key, self._own, self._sent, body, echo=self.echo if echo is None else echo)

    def receive(self, data: bytes) -> Datagram[Body] | None:  # noqa: PLR0911 - one for each check, in order
        """The datagram if it is the newest so far of its session; None otherwise, and counted."""
        counts = self.counts
        self.greeting = 0
        datagram: Datagram[Any] | Rejected = decode(self._key, data)
        if isinstance(datagram, Rejected):
            setattr(counts, datagram.reason, getattr(counts, datagram.reason) + 1)
            return None
        if not isinstance(datagram.body, self._takes):
            counts.unexpected += 1
            return None
        if self._own and (datagram.echo != self._own or datagram.session == self._own):
            counts.unproven += 1
            if datagram.session == self._own:  # sent back to its sender
                return None
            self.greeting = self._heard = datagram.session
            return None
        if datagram.session != self.session:
            if datagram.session in self._old or len(self._old) >= self.MOST_SESSIONS:
                counts.old_session += 1
                return None
            self._begin(datagram)
            return datagram
        step = datagram.sequence - self.sequence
        if step > 0:
            counts.accepted += 1
            counts.lost += step - 1
            self.sequence = datagram.sequence
            self._seen = ((self._seen << min(step, self._REORDER_WINDOW)) | 1) & (
                (1 << self._REORDER_WINDOW) - 1
            )
            return datagram
        behind = -step
        if behind < self._REORDER_WINDOW and not self._seen >> behind & 1:
            self._seen |= 1 << behind
            counts.late += 1
            counts.lost -= 1
        else:
            counts.duplicate += 1
        return None

    def _begin(self, datagram: Datagram[Body]) -> None:
        if self.session:
            self._old.add(self.session)
        self.session = datagram.session
        self.sequence = datagram.sequence
        self._seen = (1 << self._REORDER_WINDOW) - 1  # what came before the first one seen is not missed
        self.counts.sessions += 1
        self.counts.accepted += 1
