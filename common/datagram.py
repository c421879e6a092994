"""The datagrams: msgpack, versioned, with session and sequence number, signed. docs/protocol.md describes
them.

A datagram is a msgpack array [version, kind, session, sequence, body...] followed by a 16-byte keyed BLAKE2s
tag of all bytes before it. Sessions are random 63-bit numbers, drawn when a process starts; sequences count
up from 1.
"""

import hmac
from enum import IntEnum
from hashlib import blake2s
from typing import Any, NamedTuple

import msgpack

VERSION = 1
TAG_BYTES = 16
MAX_DATAGRAM_BYTES = 1200
DEMO_KEY = b"stillarm demo key, loopback only"


class Kind(IntEnum):
    """What a datagram says; the number of fields in its body goes with it."""

    TIMESTAMP = 1  # controller -> supervisor: n_c
    VISUAL = 2  # supervisor -> controller: session of the timestamps, n_i, and the visual sample
    DRIVE_COMMAND = 3  # controller -> drive gateway: joint velocity
    DRIVE_STATE = 4  # drive gateway -> controller: joint position and velocity, status
    REFERENCE = 5  # operator -> controller: joint velocity reference, whether damping is allowed


BODY_FIELDS = {
    Kind.TIMESTAMP: 1,
    Kind.VISUAL: 15,
    Kind.DRIVE_COMMAND: 1,
    Kind.DRIVE_STATE: 4,
    Kind.REFERENCE: 2,
}


class Datagram(NamedTuple):
    """A datagram whose tag held and whose shape is right. The body's values are checked by whoever takes
    them.
    """

    kind: int
    session: int
    sequence: int
    body: tuple[Any, ...]


class Rejected(NamedTuple):
    """Why a datagram was not accepted: 'malformed', 'forged' or 'foreign_version'."""

    reason: str


def encode(key: bytes, kind: int, session: int, sequence: int, body: tuple[Any, ...]) -> bytes:
    """A datagram ready to send. `key` has 16 to 32 bytes."""
    payload: bytes = msgpack.packb((VERSION, kind, session, sequence, *body))
    return payload + blake2s(payload, key=key, digest_size=TAG_BYTES).digest()


def decode(key: bytes, data: bytes) -> Datagram | Rejected:  # noqa: PLR0911 - one for each check, in order
    """Check and read a datagram: size, then tag, then version, then shape. Never raises for any bytes."""
    if not TAG_BYTES + 5 <= len(data) <= MAX_DATAGRAM_BYTES:
        return Rejected("malformed")
    payload = data[:-TAG_BYTES]
    if not hmac.compare_digest(blake2s(payload, key=key, digest_size=TAG_BYTES).digest(), data[-TAG_BYTES:]):
        return Rejected("forged")
    try:
        fields = msgpack.unpackb(payload, use_list=False)
    except (ValueError, TypeError, RecursionError, msgpack.exceptions.UnpackException):
        return Rejected("malformed")
    if not isinstance(fields, tuple) or len(fields) < 4:
        return Rejected("malformed")
    version, kind, session, sequence = fields[:4]
    if type(version) is not int or version != VERSION:  # True and 1.0 equal 1
        return Rejected("foreign_version")
    if (
        type(kind) is not int
        or BODY_FIELDS.get(kind) != len(fields) - 4  # type: ignore[call-overload]
        or type(session) is not int
        or type(sequence) is not int
        or session <= 0
        or sequence <= 0
    ):
        return Rejected("malformed")
    return Datagram(kind, session, sequence, fields[4:])
