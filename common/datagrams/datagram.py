"""Datagrams: a message of common/datagrams/messages.py with its head, packed and signed. docs/protocol.md
describes them.

A datagram is a msgpack array [version, kind, session, echo, sequence, body...] followed by a 16-byte keyed BLAKE2s
tag of all bytes before it. Sessions are random numbers, drawn when a process starts; echo is the session of whom it is
meant for, as far as it is known; sequences count up from 1.
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
    """The first two fields of an array, whatever they are: the version tells whether the rest can be read."""

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
