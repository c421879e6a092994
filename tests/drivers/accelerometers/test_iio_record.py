"""Channels of a record, any layout that the kernel allows."""

from hypothesis import given
from hypothesis import strategies as st

from stillarm.drivers.accelerometers.iio_record import Channel


@given(
    value=st.integers(-(1 << 12), (1 << 12) - 1),
    big_endian=st.booleans(),
    at=st.integers(0, 5),
    shift=st.integers(0, 3),
)
def test_any_channel_is_decoded(value: int, big_endian: bool, at: int, shift: int) -> None:
    stored = ((value & 0x1FFF) << shift | 0x7 >> 3 - shift).to_bytes(2, "big" if big_endian else "little")
    channel = Channel(at, 2, big_endian, True, 13, shift)
    assert channel.decode(b"\xff" * at + stored + b"\xff" * 3) == value
