"""A datagram as docs/protocol.md words it, packed apart from common/datagrams/datagram.py: any body, right or wrong."""

from collections.abc import Sequence
from hashlib import blake2s

import msgpack

FIELDS = {1: 2, 2: 18, 3: 1, 4: 4, 5: 2, 6: 0, 7: 1, 8: 2, 9: 1}
"""How many fields the body of each kind has."""
TIMESTAMP, VISUAL, DRIVE_COMMAND, DRIVE_STATE, REFERENCE, HELLO, OPERATOR_COMMAND, ADJUSTMENT, DRIVE_INPUT = (
    FIELDS
)


def signed(key: bytes, payload: bytes) -> bytes:
    return payload + blake2s(payload, key=key, digest_size=16).digest()


def plain_datagram(
    key: bytes, kind: int, session: int, sequence: int, body: Sequence[object], *, echo: int = 0
) -> bytes:
    """Raises OverflowError or ValueError for what msgpack cannot hold."""
    return signed(key, msgpack.packb((2, kind, session, echo, sequence, *body)))
