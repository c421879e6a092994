"""Frames of this maker's devices, byte by byte."""

import pytest

from stillarm.drivers.accelerometers.serial_decoders.framing import FrameDecoder
from stillarm.drivers.accelerometers.serial_decoders.witmotion import WITMOTION
from stillarm.drivers.emulation.serial_frames import (
    witmotion_acceleration,
    witmotion_frame,
)


def test_witmotion_takes_accelerations_among_other_frames() -> None:
    data = witmotion_frame(0x52, (1, 2, 3, 4)) + bytes.fromhex("5551000800F8FF07C40979")
    sample = FrameDecoder(WITMOTION).feed(data)
    assert len(sample) == 1
    assert sample[0].x_m_s2 == pytest.approx(9.80665)
    assert sample[0].y_m_s2 == pytest.approx(-9.80665)
    assert FrameDecoder(WITMOTION).feed(witmotion_acceleration(1.0, 2.0, 3.0))[0].z_m_s2 == pytest.approx(
        3, abs=0.003
    )
