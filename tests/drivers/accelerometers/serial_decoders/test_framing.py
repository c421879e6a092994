"""Every serial decoder: whole streams, any chunks, any garbage, broken frames."""

from collections.abc import Callable
from math import isnan

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from stillarm.drivers.accelerometers.serial_decoders.framing import FrameDecoder, Framing, SerialSample
from stillarm.drivers.accelerometers.serial_decoders.microcontroller import MICROCONTROLLER
from stillarm.drivers.accelerometers.serial_decoders.vectornav import VECTORNAV
from stillarm.drivers.accelerometers.serial_decoders.witmotion import WITMOTION
from stillarm.drivers.accelerometers.serial_decoders.xsens import XSENS
from stillarm.drivers.emulation.serial_frames import (
    ccitt_crc,
    microcontroller_frame,
    vectornav_data,
    witmotion_frame,
    xsens_data,
)

Encode = Callable[[int], bytes]


def _micro(index: int) -> bytes:
    return microcontroller_frame(1, 0, index, 1000 * index, (1000 * index, -250_000, 9_806_650))


# A frame whose x axis is 1e-3 m/s^2 (of WitMotion: a count) times the index.
STREAMS: dict[str, tuple[Framing, Encode, float]] = {
    "witmotion": (WITMOTION, lambda i: witmotion_frame(0x51, (i, -51, 2048, 2500)), 16 * 9.80665 / 32768),
    "xsens": (XSENS, lambda i: xsens_data((1e-3 * i, -0.25, 9.80665), i, 10 * i), 1e-3),
    "vectornav": (VECTORNAV, lambda i: vectornav_data((1e-3 * i, -0.25, 9.80665), 1_250_000 * i), 1e-3),
    "microcontroller": (MICROCONTROLLER, _micro, 1e-3),
}
EVERY = pytest.mark.parametrize("name", sorted(STREAMS))


def same(one: list[SerialSample], other: list[SerialSample]) -> bool:
    """Equal, with no time equal to no time."""
    return [s[:5] for s in one] == [s[:5] for s in other] and all(
        a.time_s == b.time_s or (isnan(a.time_s) and isnan(b.time_s)) for a, b in zip(one, other, strict=True)
    )


def chunks(data: bytes, lengths: list[int]) -> list[bytes]:
    """The data cut at the given lengths, over and over."""
    pieces, at = [], 0
    while at < len(data):
        length = lengths[len(pieces) % len(lengths)]
        pieces.append(data[at : at + length])
        at += length
    return pieces


@EVERY
def test_a_clean_stream_gives_every_sample(name: str) -> None:
    framing, encode, unit = STREAMS[name]
    decoder = FrameDecoder(framing)
    samples = decoder.feed(b"".join(encode(i) for i in range(200)))
    assert [round(sample.x_m_s2 / unit) for sample in samples] == list(range(200))
    assert all(abs(sample.y_m_s2 + 0.25) < 0.01 for sample in samples)
    assert all(abs(sample.z_m_s2 - 9.80665) < 0.01 for sample in samples)
    assert (decoder.frames, decoder.rejected) == (200, 0)


@pytest.mark.slow
@EVERY
@settings(max_examples=60, deadline=None)
@given(
    garbage=st.lists(st.binary(max_size=40), min_size=5, max_size=5),
    lengths=st.lists(st.integers(1, 60), min_size=1, max_size=10),
)
def test_what_comes_out_does_not_depend_on_the_chunks(
    name: str, garbage: list[bytes], lengths: list[int]
) -> None:
    framing, encode, _ = STREAMS[name]
    data = b"".join(encode(i) + garbage[i] for i in range(5))
    whole = FrameDecoder(framing).feed(data)
    decoder = FrameDecoder(framing)
    pieces = [sample for chunk in chunks(data, lengths) for sample in decoder.feed(chunk)]
    assert same(whole, pieces)


@pytest.mark.slow
@EVERY
@settings(max_examples=150, deadline=None)
@given(garbage=st.binary(max_size=600))
def test_after_any_garbage_it_is_back_within_the_longest_frame(name: str, garbage: bytes) -> None:
    """Garbage may end in what begins a frame; it then costs what that frame could hold, and two frames more."""
    framing, encode, unit = STREAMS[name]
    one = len(encode(0))
    held_up = framing.longest // one + 2
    samples = FrameDecoder(framing).feed(garbage + b"".join(encode(i) for i in range(held_up + 20)))
    seen = [round(sample.x_m_s2 / unit) for sample in samples]
    assert seen[-20:] == list(range(held_up, held_up + 20))


@pytest.mark.slow
@EVERY
@settings(max_examples=100, deadline=None)
@given(place=st.integers(0, 10_000), flipped=st.integers(1, 255))
@example(place=3, flipped=61)  # an Xsens frame whose length breaks so that the sum holds
def test_a_broken_frame_is_never_taken(name: str, place: int, flipped: int) -> None:
    framing, encode, unit = STREAMS[name]
    data = bytearray(b"".join(encode(i) for i in range(7, 10)))
    one = len(encode(7))
    at = one + place % one  # in the second of three
    data[at] ^= flipped
    seen = [
        round(sample.x_m_s2 / unit) for sample in FrameDecoder(framing).feed(bytes(data) + 300 * encode(9))
    ]
    assert seen[0] == 7
    assert set(seen[1:]) == {9}


@pytest.mark.slow
@EVERY
@settings(max_examples=100, deadline=None)
@given(data=st.binary(max_size=2000))
def test_garbage_neither_raises_nor_piles_up(name: str, data: bytes) -> None:
    framing = STREAMS[name][0]
    decoder = FrameDecoder(framing)
    decoder.feed(data)
    assert len(decoder._buffer) <= framing.longest


@EVERY
def test_a_byte_lost_costs_one_frame(name: str) -> None:
    framing, encode, unit = STREAMS[name]
    data = b"".join(encode(i) for i in range(3, 40))
    one = len(encode(3))
    data = data[: 5 * one + 3] + data[5 * one + 4 :]
    seen = [round(s.x_m_s2 / unit) for s in FrameDecoder(framing).feed(data + 20 * encode(0))]
    assert seen[:36] == [i for i in range(3, 40) if i != 8]


def test_crc_is_that_of_the_published_check_value() -> None:
    assert ccitt_crc(b"123456789") == 0x31C3  # CRC-16/XMODEM's


def test_microcontroller_description_and_fault() -> None:
    decoder = FrameDecoder(MICROCONTROLLER)
    assert decoder.feed(microcontroller_frame(2, 0, 0, 0, (1_000_000, 39_200_000, 500))) == []
    told = decoder.description
    assert told is not None
    assert (told.rate_hz, told.range_m_s2, told.delay_s) == (1000.0, pytest.approx(39.2), pytest.approx(5e-4))
    assert decoder.feed(microcontroller_frame(1, 1, 1, 0, (1, 2, 3))) == []  # the sensor's fault
    (sample,) = decoder.feed(microcontroller_frame(1, 2, 65535, 4_000_000_000, (-1, 2, 2_147_483_647)))
    assert sample == (-1e-6, 2e-6, pytest.approx(2147.483647), 65535, 2, pytest.approx(4000.0))
