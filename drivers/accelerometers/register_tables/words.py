"""Decodes three axes from the bytes of an accelerometer."""

import struct

_LITTLE, _BIG = struct.Struct("<3h"), struct.Struct(">3h")


def little_words(data: bytes) -> tuple[int, int, int]:
    """Three signed 16-bit words, low byte first."""
    return _LITTLE.unpack(data)


def big_words(data: bytes) -> tuple[int, int, int]:
    """Three signed 16-bit words, high byte first."""
    return _BIG.unpack(data)


def big_20_bits(data: bytes) -> tuple[int, int, int]:
    """Three signed 20-bit numbers, each left-justified in three bytes, high byte first."""
    whole = int.from_bytes
    return (
        whole(data[0:3], "big", signed=True) >> 4,
        whole(data[3:6], "big", signed=True) >> 4,
        whole(data[6:9], "big", signed=True) >> 4,
    )
