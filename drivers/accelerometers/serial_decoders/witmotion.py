"""WitMotion's serial frames: 0x55, kind (0x51: acceleration), eight bytes, the low byte of the sum of the ten."""

import struct

from stillarm.drivers.accelerometers.serial_decoders.framing import Framing, SerialSample
from stillarm.drivers.standard_gravity import STANDARD_GRAVITY_M_S2

_LENGTH = 11
_ACCELERATION = 0x51
_FULL_SCALE_G = 16.0
_LAYOUT = struct.Struct("<2x3h")
_M_S2_PER_COUNT = _FULL_SCALE_G * STANDARD_GRAVITY_M_S2 / 32768.0


def _length(buffer: bytearray, at: int) -> int | None:
    if at + 1 >= len(buffer):
        return None
    return _LENGTH if buffer[at + 1] & 0xF0 == 0x50 else 0


def _valid(frame: bytes) -> bool:
    return sum(frame[:-1]) & 0xFF == frame[-1]


def _sample(frame: bytes) -> SerialSample | None:
    if frame[1] != _ACCELERATION:
        return None
    x, y, z = _LAYOUT.unpack_from(frame)
    return SerialSample(x * _M_S2_PER_COUNT, y * _M_S2_PER_COUNT, z * _M_S2_PER_COUNT)


WITMOTION = Framing(b"\x55", _LENGTH, _length, _valid, _sample)
