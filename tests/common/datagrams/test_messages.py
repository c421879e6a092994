"""The table of messages: the same bytes on the wire as before there was a table, and the tables of
docs/protocol.md.
"""

from math import nan

import msgspec
import pytest

from stillarm.common.datagrams.datagram import Datagram, decode, encode, kind_of
from stillarm.common.datagrams.fields import plain_types
from stillarm.common.datagrams.messages import (
    MESSAGES,
    Adjustment,
    DriveCommand,
    DriveInput,
    DriveState,
    Hello,
    Message,
    OperatorCommand,
    Reference,
    Timestamp,
    Visual,
)
from tests.reference.plain_datagram import FIELDS, plain_datagram

KEY = b"0123456789abcdef"
SESSION, OWN = (1 << 62) + 5, (1 << 62) + 9
RECORDED: list[tuple[Message, str]] = [  # by the program as it was before this table
    (
        Timestamp(1234, 12.5),
        "970201cf4000000000000005cf4000000000000009ce00011170cd04d2cb4029000000000000"
        "f79a7b6cc22e3912754b12fb92a967e7",
    ),
    (
        Visual(
            OWN, 7, 1200, 0, 0.5, -0.25, 0.01, 1e-3, 2e-3, -5e-4, 1e-8, nan, 0.015, 90, 88, 12.5, 99.5, 99.75
        ),
        "dc00170202cf4000000000000005cf4000000000000009ce00011170cf400000000000000907cd04b000cb3fe0000000000000"
        "cbbfd0000000000000cb3f847ae147ae147bcb3f50624dd2f1a9fccb3f60624dd2f1a9fccbbf40624dd2f1a9fc"
        "cb3e45798ee2308c3acb7ff8000000000000cb3f8eb851eb851eb85a58cb4029000000000000cb4058e00000000000"
        "cb4058f000000000008ed618bf18ac47d06c1aaa02a8015a47",
    ),
    (
        DriveCommand(-0.25),
        "960203cf4000000000000005cf4000000000000009ce00011170cbbfd0000000000000f10434c52ff1f5add92d81f7de831ecf",
    ),
    (
        DriveState(0.5, -0.125, 1, 41),
        "990204cf4000000000000005cf4000000000000009ce00011170cb3fe0000000000000cbbfc00000000000000129"
        "176ebd1d347f3cde94664019989ec6fc",
    ),
    (
        Reference(0.2, False),
        "970205cf4000000000000005cf4000000000000009ce00011170cb3fc999999999999ac2"
        "54319fe3ba6e4c5091a7be4332ff78a6",
    ),
    (Hello(), "950206cf4000000000000005cf4000000000000009ce00011170ea57540366a04801a4bf622c0d177279"),
    (
        OperatorCommand(8),
        "960207cf4000000000000005cf4000000000000009ce000111700864154ea1c4466fcfecd4bf34b2124a88",
    ),
    (  # younger than the table: by tests/reference/plain_datagram.py
        Adjustment("fused", 0.15),
        "970208cf4000000000000005cf4000000000000009ce00011170a56675736564cb3fc3333333333333"
        "aed06c15cf8e5cbe62265e2e10fa0658",
    ),
    (  # likewise
        DriveInput(1.5),
        "960209cf4000000000000005cf4000000000000009ce00011170cb3ff8000000000000d53e66f8b14c39c95d6c83176bb15624",
    ),
]


@pytest.mark.parametrize(("message", "recorded"), RECORDED)
def test_the_wire_is_what_it_was_before_the_table(message: Message, recorded: str) -> None:
    data = bytes.fromhex(recorded)
    assert encode(KEY, SESSION, 70_000, message, echo=OWN) == data
    assert repr(decode(KEY, data)) == repr(Datagram(SESSION, OWN, 70_000, message))


def test_every_message_is_in_the_table_with_a_number_of_its_own() -> None:
    assert {kind_of(message): len(message.__struct_fields__) for message in MESSAGES} == FIELDS
    assert set(Message.__subclasses__()) == set(MESSAGES)


@pytest.mark.parametrize(("message", "recorded"), RECORDED)
def test_a_value_of_another_type_or_out_of_its_bounds_is_malformed(message: Message, recorded: str) -> None:
    body = msgspec.structs.astuple(message)
    for at, plain in enumerate(plain_types(type(message)).values()):
        text = 1 if plain is str else "1"
        for wrong in (None, text, [], {}, b"", 2 if plain is bool else True, "x" if plain is float else 1.0):
            changed = (*body[:at], wrong, *body[at + 1 :])
            data = plain_datagram(KEY, kind_of(type(message)), SESSION, 1, changed)
            assert decode(KEY, data) == ("malformed",), (message, at, wrong)


@pytest.mark.parametrize(
    ("kind", "body"),
    [
        (1, (-1, 0.5)),
        (5, (nan, True)),
        (5, (1e6, True)),
        (5, (-1e6, True)),
        (7, (0,)),
        (7, (16,)),
        (7, (-1,)),
        (8, ("x" * 65, 0.1)),
    ],
)
def test_bounds(kind: int, body: tuple[object, ...]) -> None:
    assert decode(KEY, plain_datagram(KEY, kind, SESSION, 1, body)) == ("malformed",)
