"""The datagrams: msgpack, versioned, with session and sequence number, signed. docs/protocol.md describes
them.

A datagram is a msgpack array [version, kind, session, echo, sequence, body...] followed by a 16-byte keyed BLAKE2s
tag of all bytes before it. Sessions are random numbers, drawn when a process starts; echo is the session of whom it is
meant for, as far as it is known; sequences count up from 1.
"""

import hmac
from enum import IntEnum
from hashlib import blake2s
from typing import Any, NamedTuple

import msgpack

VERSION = 2
TAG_BYTES = 16
MAX_DATAGRAM_BYTES = 1200
DEMO_KEY = b"stillarm demo key, loopback only"
_HEAD_FIELDS = 5


class Kind(IntEnum):
    """What a datagram says; the number of fields in its body goes with it."""

    TIMESTAMP = 1  # controller -> supervisor: n_c
    VISUAL = 2  # supervisor -> controller: session of the timestamps, n_i, and the visual sample
    DRIVE_COMMAND = 3  # controller -> drive gateway: joint velocity
    DRIVE_STATE = 4  # drive gateway -> controller: joint position and velocity, status
    REFERENCE = 5  # operator -> controller: joint velocity reference, whether damping is allowed
    HELLO = 6  # whoever was addressed without its session -> who did so
    OPERATOR = 7  # operator -> controller: arm, disarm, clear, stop


BODY_FIELDS = {
    Kind.TIMESTAMP: 2,
    Kind.VISUAL: 18,
    Kind.DRIVE_COMMAND: 1,
    Kind.DRIVE_STATE: 4,
    Kind.REFERENCE: 2,
    Kind.HELLO: 0,
    Kind.OPERATOR: 1,
}


class Datagram(NamedTuple):
    """A datagram whose tag held and whose shape is right. The body's values are checked by whoever takes
    them. echo: the session of the receiver, as the sender knows it; 0 where it knows none.
    """

    kind: int
    session: int
    sequence: int
    body: tuple[Any, ...]
    echo: int = 0


class Rejected(NamedTuple):
    """Why a datagram was not accepted: 'malformed', 'forged' or 'foreign_version'."""

    reason: str


def encode(
    key: bytes, kind: int, session: int, sequence: int, body: tuple[Any, ...], *, echo: int = 0
) -> bytes:
    """A datagram ready to send. `key` has 16 to 32 bytes; echo: common.peer.Peer.echo."""
    payload: bytes = msgpack.packb((VERSION, kind, session, echo, sequence, *body))
    return payload + blake2s(payload, key=key, digest_size=TAG_BYTES).digest()


def decode(key: bytes, data: bytes) -> Datagram | Rejected:  # noqa: PLR0911 - one for each check, in order
    """Check and read a datagram: size, then tag, then version, then shape. Never raises for any bytes."""
    if not TAG_BYTES + _HEAD_FIELDS + 1 <= len(data) <= MAX_DATAGRAM_BYTES:
        return Rejected("malformed")
    payload = data[:-TAG_BYTES]
    if not hmac.compare_digest(blake2s(payload, key=key, digest_size=TAG_BYTES).digest(), data[-TAG_BYTES:]):
        return Rejected("forged")
    try:
        fields = msgpack.unpackb(payload, use_list=False)
    except (ValueError, TypeError, RecursionError, msgpack.exceptions.UnpackException):
        return Rejected("malformed")
    if not isinstance(fields, tuple) or not fields:
        return Rejected("malformed")
    if type(fields[0]) is not int or fields[0] != VERSION:  # True and 2.0 are no 2
        return Rejected("foreign_version")
    if len(fields) < _HEAD_FIELDS:
        return Rejected("malformed")
    _, kind, session, echo, sequence = fields[:_HEAD_FIELDS]
    if (
        type(kind) is not int
        or BODY_FIELDS.get(kind) != len(fields) - _HEAD_FIELDS  # type: ignore[call-overload]
        or type(session) is not int
        or type(echo) is not int
        or type(sequence) is not int
        or session <= 0
        or echo < 0
        or sequence <= 0
    ):
        return Rejected("malformed")
    return Datagram(kind, session, sequence, fields[_HEAD_FIELDS:], echo)
