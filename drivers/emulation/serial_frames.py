"""Encoders for emulated serial accelerometers, independent of the decoders that they test."""

import struct
from collections.abc import Sequence

from stillarm.drivers.standard_gravity import STANDARD_GRAVITY_M_S2

_WITMOTION_COUNTS_PER_M_S2 = 32768.0 / (16.0 * STANDARD_GRAVITY_M_S2)


def witmotion_frame(kind: int, words: Sequence[int]) -> bytes:
    """A frame of four signed words."""
    body = struct.pack("<BB4h", 0x55, kind, *words)
    return body + bytes((sum(body) % 256,))


def witmotion_acceleration(x: float, y: float, z: float) -> bytes:
    """The frame of an acceleration, m/s^2, with a temperature of 25 degrees."""
    counts = [min(max(round(a * _WITMOTION_COUNTS_PER_M_S2), -32768), 32767) for a in (x, y, z)]
    return witmotion_frame(0x51, (*counts, 2500))


def xsens_message(identifier: int, data: bytes) -> bytes:
    """A message. The sum of all bytes after the first is a multiple of 256."""
    body = bytes((0xFF, identifier, len(data))) + data
    return b"\xfa" + body + bytes(((256 - sum(body) % 256) % 256,))


def xsens_data(xyz: Sequence[float], counter: int, time_10khz: int, identifier: int = 0x4040) -> bytes:
    """An MTData2 message: packet counter, fine time, acceleration in single precision."""
    fields = struct.pack(">HBH", 0x1020, 2, counter & 0xFFFF)
    fields += struct.pack(">HBI", 0x1060, 4, time_10khz & 0xFFFFFFFF)
    fields += struct.pack(">HB3f", identifier, 12, *xyz)
    return xsens_message(0x36, fields)


def ccitt_crc(data: bytes) -> int:
    """The CRC of polynomial 0x1021 and initial value 0, as VectorNav's manual computes it."""
    crc = 0
    for byte in data:
        crc = (crc >> 8 | crc << 8) & 0xFFFF
        crc ^= byte
        crc ^= (crc & 0xFF) >> 4
        crc ^= crc << 12 & 0xFFFF
        crc ^= (crc & 0xFF) << 5
    return crc


def vectornav_data(xyz: Sequence[float], time_ns: int) -> bytes:
    """Binary output of the common group's time since start-up and acceleration."""
    body = struct.pack("<BHQ3f", 0x01, 0x0101, time_ns, *xyz)
    return b"\xfa" + body + struct.pack(">H", ccitt_crc(body))


def vectornav_text(text: str) -> bytes:
    """A line of text with its checksum."""
    checksum = 0
    for byte in text.encode():
        checksum ^= byte
    return f"${text}*{checksum:02X}\r\n".encode()


def microcontroller_frame(
    kind: int, status: int, counter: int, time_us: int, numbers: Sequence[int]
) -> bytes:
    """A frame of docs/serial-stream.md."""
    body = struct.pack("<BBHI3i", kind, status, counter & 0xFFFF, time_us & 0xFFFFFFFF, *numbers)
    return b"\xa5\x5a" + body + struct.pack(">H", ccitt_crc(body))
