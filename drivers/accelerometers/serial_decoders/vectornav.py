"""VectorNav's binary output: FA, groups, a mask of fields per group, payload, CRC; little-endian except the CRC.

The decoder reads groups 1 (common) and 3 (inertial), with the fields of VectorNav's tables. The CRC is CCITT's
(polynomial 0x1021, initial value 0); over all bytes after FA, including its own, it is 0.
"""

import binascii
import struct
from math import nan

from stillarm.drivers.accelerometers.serial_decoders.framing import Framing, SerialSample

_COMMON, _INERTIAL = 0x01, 0x04
_LENGTHS = {
    _COMMON: (8, 8, 8, 12, 16, 12, 24, 12, 12, 24, 20, 28, 2, 4, 8),
    _INERTIAL: (2, 12, 12, 12, 4, 4, 16, 12, 12, 12, 12, 2),
}
_TIME_STARTUP = (_COMMON, 0)
# Prefer compensated to uncompensated fields.
_ACCELERATIONS = ((_COMMON, 8), (_INERTIAL, 9), (_COMMON, 9), (_INERTIAL, 2))
_VECTOR, _TIME_NS = struct.Struct("<3f"), struct.Struct("<Q")
_LONGEST = 6 + sum(sum(lengths) for lengths in _LENGTHS.values()) + 2


def _length(buffer: bytearray, at: int) -> int | None:
    if at + 2 > len(buffer):
        return None
    groups = buffer[at + 1]
    if not groups or groups & ~(_COMMON | _INERTIAL):
        return 0
    masks_end = at + 2 + 2 * groups.bit_count()
    if masks_end > len(buffer):
        return None
    fields = _fields(bytes(buffer[at:masks_end]))
    return masks_end - at + sum(length for _, _, length in fields) + 2 if fields else 0


def _fields(frame: bytes) -> list[tuple[int, int, int]]:
    """(group, bit, length) of every field in the order of transmission; none if the masks name an unknown field."""
    fields = []
    at = 2
    for group, lengths in _LENGTHS.items():
        if not frame[1] & group:
            continue
        mask = frame[at] | frame[at + 1] << 8
        at += 2
        if mask >> len(lengths):
            return []
        fields += [(group, bit, length) for bit, length in enumerate(lengths) if mask >> bit & 1]
    return fields


def _valid(frame: bytes) -> bool:
    return binascii.crc_hqx(frame[1:], 0) == 0


def _sample(frame: bytes) -> SerialSample | None:
    at = 2 + 2 * frame[1].bit_count()
    places = {}
    for group, bit, length in _fields(frame):
        places[group, bit] = at
        at += length
    for field in _ACCELERATIONS:
        if field in places:
            x, y, z = _VECTOR.unpack_from(frame, places[field])
            stamped = places.get(_TIME_STARTUP)
            time_s = nan if stamped is None else _TIME_NS.unpack_from(frame, stamped)[0] * 1e-9
            return SerialSample(x, y, z, -1, -1, time_s)
    return None


VECTORNAV = Framing(b"\xfa", _LONGEST, _length, _valid, _sample)
