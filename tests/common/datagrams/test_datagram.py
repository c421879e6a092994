"""Datagrams: what was encoded is decoded, anything else is rejected with a reason and never raises."""

import msgpack
import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.datagrams.datagram import MAX_DATAGRAM_BYTES, Datagram, Rejected, decode, encode, kind_of
from stillarm.common.datagrams.fields import plain_types
from stillarm.common.datagrams.messages import MESSAGES, Message, OperatorCommand, Reference, Timestamp
from tests.reference.plain_datagram import FIELDS, plain_datagram
from tests.reference.plain_datagram import signed as signed_by

KEY = b"0123456789abcdef"
_plain = (
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**64 - 1)
    | st.floats(allow_nan=False)
    | st.text(max_size=8)
)
_values = st.recursive(
    _plain | st.binary(max_size=8), lambda v: st.lists(v, max_size=3) | st.dictionaries(_plain, v, max_size=2)
)
_numbers = st.integers(1, 2**63 - 1)


def signed(payload: bytes) -> bytes:
    return signed_by(KEY, payload)


@st.composite
def messages(draw: st.DrawFn) -> Message:
    """Any message, of values within the table's bounds."""
    message = draw(st.sampled_from(MESSAGES))
    largest = {OperatorCommand: 15, Reference: 1e6}.get(message, 2**63)
    drawn = {
        float: st.floats(-largest, largest, exclude_min=True, exclude_max=True)
        if message is Reference
        else st.floats(),
        int: st.integers(1, int(largest)),
        bool: st.booleans(),
        str: st.text(max_size=64),
    }
    return message(*(draw(drawn[plain]) for plain in plain_types(message).values()))


@settings(deadline=None)
@given(messages(), _numbers, _numbers, st.just(0) | _numbers)
def test_a_datagram_comes_back_and_is_plain_msgpack(
    message: Message, session: int, sequence: int, echo: int
) -> None:
    data = encode(KEY, session, sequence, message, echo=echo)
    body = msgspec.structs.astuple(message)
    assert data == plain_datagram(KEY, kind_of(type(message)), session, sequence, body, echo=echo)
    assert repr(decode(KEY, data)) == repr(Datagram(session, echo, sequence, message))


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=200))
def test_any_bytes_are_rejected(data: bytes) -> None:
    assert isinstance(decode(KEY, data), Rejected)


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=100))
def test_any_signed_bytes_never_raise(payload: bytes) -> None:
    decoded = decode(KEY, signed(payload))
    assert isinstance(decoded, Rejected) or msgpack.unpackb(payload)[0] == 2


@pytest.mark.slow
@settings(max_examples=200, deadline=None)
@given(st.lists(_values, max_size=6))
def test_any_signed_array_is_well_formed_or_rejected(fields: list[object]) -> None:
    decoded = decode(KEY, signed(msgpack.packb([2, *fields])))
    if isinstance(decoded, Datagram):
        assert FIELDS[kind_of(type(decoded.body))] == len(fields) - 4
        assert decoded.session > 0 and decoded.sequence > 0
    else:
        assert decoded.reason == "malformed"


@settings(deadline=None)
@given(st.data())
def test_one_changed_bit_is_a_forgery(data: st.DataObject) -> None:
    good = bytearray(encode(KEY, 5, 6, Reference(0.25, True)))
    bit = data.draw(st.integers(0, len(good) * 8 - 1))
    good[bit // 8] ^= 1 << bit % 8
    assert decode(KEY, bytes(good)) == Rejected("forged")


def test_another_key_is_a_forgery() -> None:
    assert decode(KEY[::-1], encode(KEY, 1, 1, Timestamp(3, 0.5))) == Rejected("forged")


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ([1, 1, 5, 6, 7], "foreign_version"),
        ([3, 3, 5, 0, 6, 0.1], "foreign_version"),
        ([3, 3, 5, 700], "foreign_version"),
        ([True, 3, 5, 0, 6, 0.1], "foreign_version"),
        ([2.0, 3, 5, 0, 6, 0.1], "foreign_version"),
        ([2, 99, 5, 0, 6, 0.1], "malformed"),
        ([2, True, 5, 0, 6, 0.1], "malformed"),
        ([2, 3, 5, 0, 6], "malformed"),
        ([2, 3, 5, 0, 6, 0.1, 8], "malformed"),
        ([2, 3, 0, 0, 6, 0.1], "malformed"),
        ([2, 3, 5, 0, -6, 0.1], "malformed"),
        ([2, 3, 5, 0, 6.0, 0.1], "malformed"),
        ([2, 3, True, 0, 6, 0.1], "malformed"),
        ([2, 3, 5, -1, 6, 0.1], "malformed"),
        ([2, 3, 5, 0.0, 6, 0.1], "malformed"),
        ([2, [3], 5, 0, 6, 0.1], "malformed"),
        ({"a": 1, "b": 2, "c": 3}, "malformed"),
    ],
)
def test_wrong_shapes(fields: object, reason: str) -> None:
    assert decode(KEY, signed(msgpack.packb(fields))) == Rejected(reason)


def test_sizes_beyond_the_bounds_are_malformed() -> None:
    assert decode(KEY, b"") == Rejected("malformed")
    assert decode(KEY, signed(bytes(MAX_DATAGRAM_BYTES))) == Rejected("malformed")
    assert decode(KEY, signed(b"\x91" * 1100)) == Rejected("malformed")  # nested deeper than can be read
