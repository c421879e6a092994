"""Frames of this maker's devices, byte by byte."""

import struct

import pytest

from stillarm.drivers.accelerometers.serial_decoders.framing import FrameDecoder
from stillarm.drivers.accelerometers.serial_decoders.xsens import XSENS
from stillarm.drivers.emulation.serial_frames import (
    xsens_message,
)


def test_xsens_formats_counter_and_time() -> None:
    double = struct.pack(">HB3d", 0x4023, 24, 1.5, -2.5, 3.5)
    stamped = struct.pack(">HBHHBI", 0x1020, 2, 777, 0x1060, 4, 123_456) + double
    message = xsens_message(0x36, stamped)
    assert sum(message[1:]) % 256 == 0
    (sample,) = FrameDecoder(XSENS).feed(message)
    assert sample == (1.5, -2.5, 3.5, 777, -1, pytest.approx(12.3456))
    fixed_point = xsens_message(0x36, struct.pack(">HB3i", 0x4021, 12, 1, 2, 3))
    acknowledge = xsens_message(0x31, b"")
    cut = xsens_message(0x36, struct.pack(">HB2f", 0x4020, 12, 1.0, 2.0))
    assert FrameDecoder(XSENS).feed(fixed_point + acknowledge + cut) == []
