"""Frames of this maker's devices, byte by byte."""

import struct

from stillarm.drivers.accelerometers.serial_decoders.framing import FrameDecoder
from stillarm.drivers.accelerometers.serial_decoders.vectornav import VECTORNAV
from stillarm.drivers.emulation.serial_frames import (
    ccitt_crc,
)


def test_vectornav_groups_and_fields() -> None:
    """Common: angles, acceleration; inertial: uncompensated acceleration, temperature: the compensated one is taken."""
    body = struct.pack("<BHH3f3f3ff", 0x05, 0x0108, 0x0014, 9.0, 9.0, 9.0, 1.0, 2.0, 3.0, 7.0, 7.0, 7.0, 25.0)
    (sample,) = FrameDecoder(VECTORNAV).feed(b"\xfa" + body + struct.pack(">H", ccitt_crc(body)))
    assert sample[:3] == (1.0, 2.0, 3.0)
    alone = struct.pack("<BH3f", 0x04, 0x0004, 4.0, 5.0, 6.0)
    (sample,) = FrameDecoder(VECTORNAV).feed(b"\xfa" + alone + struct.pack(">H", ccitt_crc(alone)))
    assert sample[:3] == (4.0, 5.0, 6.0)
    without = struct.pack("<BH3f", 0x01, 0x0008, 4.0, 5.0, 6.0)
    decoder = FrameDecoder(VECTORNAV)
    assert decoder.feed(b"\xfa" + without + struct.pack(">H", ccitt_crc(without))) == []
    assert decoder.frames == 1
