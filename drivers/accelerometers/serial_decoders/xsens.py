"""Xsens MTData2: FA FF, message id, length, data, checksum; the bytes behind FA sum to 0. Data: [id, length, payload].

Acceleration: 0x4020, or 0x4040 at high rate, as in three public uses of Xsens' own library. The low digit of the id is
the format: the decoder accepts floats in single (0) or double (3) precision, in any coordinate frame.
"""

import struct
from math import nan

from stillarm.drivers.accelerometers.serial_decoders.framing import Framing, SerialSample

_DATA = 0x36
_EXTENDED = 0xFF
_ACCELERATIONS = (0x4020, 0x4040)
_COUNTER, _TIME_FINE = 0x1020, 0x1060
_TIME_UNIT_S = 1e-4
_VECTORS = {0x0: struct.Struct(">3f"), 0x3: struct.Struct(">3d")}
_AROUND = 5  # FA, FF, message id, length, checksum


def _length(buffer: bytearray, at: int) -> int | None:
    if at + 4 > len(buffer):
        return None
    length = buffer[at + 3]
    return 0 if length == _EXTENDED else length + _AROUND


def _valid(frame: bytes) -> bool:
    """An 8-bit sum accepts one broken frame in 256. As a second check, the fields must fill the data exactly."""
    if sum(frame[1:]) & 0xFF:
        return False
    if frame[2] != _DATA:
        return True
    at, end = 4, len(frame) - 1
    while at + 3 <= end:
        at += 3 + frame[at + 2]
    return at == end


def _sample(frame: bytes) -> SerialSample | None:
    if frame[2] != _DATA:
        return None
    xyz: tuple[float, float, float] | None = None
    counter, time_s = -1, nan
    at, end = 4, len(frame) - 1
    while at + 3 <= end:
        kind = frame[at] << 8 | frame[at + 1]
        length = frame[at + 2]
        payload = frame[at + 3 : at + 3 + length]
        if kind & 0xFFF0 in _ACCELERATIONS:
            layout = _VECTORS.get(kind & 0x3)
            if layout is not None and len(payload) == layout.size:
                xyz = layout.unpack(payload)
        elif kind == _COUNTER and len(payload) == 2:
            counter = int.from_bytes(payload, "big")
        elif kind == _TIME_FINE and len(payload) == 4:
            time_s = int.from_bytes(payload, "big") * _TIME_UNIT_S
        at += 3 + length
    return None if xyz is None else SerialSample(*xyz, counter, -1, time_s)


XSENS = Framing(b"\xfa\xff", 254 + _AROUND, _length, _valid, _sample)
