"""The chip's registers, as its data sheet has them."""

import pytest

from tests.fixtures.register_chips import Chip, G


@pytest.mark.parametrize(("part", "address"), [("mpu6050", 0x68)])
def test_mpu6050(part: str, address: int, chip: Chip) -> None:
    assert chip.get(0x75) == b"\x68"
    assert chip.get(0x6B) == b"\x40"  # asleep
    chip.feel(G)
    chip.put(0x6B, 0x01)
    chip.put(0x1A, 0x01)
    chip.feel(G, -G / 2)
    assert chip.get(0x3A, 7) == bytes.fromhex("00 4000 E000 0000")  # not told unless it is enabled
    chip.put(0x38, 0x01)
    chip.feel(G)
    assert chip.get(0x3B, 6)[:2] == b"\x40\x00"
    assert chip.get(0x3A) == b"\x01"  # freed by its own read alone
    assert chip.get(0x3A) == b"\x00"
    chip.put(0x1C, 0x18)
    chip.feel(G)
    assert chip.get(0x3B, 2) == b"\x08\x00"
