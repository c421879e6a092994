"""The chip's registers, as its data sheet has them."""

import pytest

from tests.fixtures.register_chips import Chip, G


@pytest.mark.parametrize(("part", "address"), [("adxl345", 0x53)])
def test_adxl345(part: str, address: int, chip: Chip) -> None:
    assert chip.get(0x00) == b"\xe5"
    assert chip.get(0x2C) == b"\x0a"  # 100 Hz
    chip.feel(G)
    assert chip.get(0x30) == b"\x00"  # standby
    chip.put(0x2D, 0x08)
    chip.put(0x2C, 0x0D)
    chip.put(0x31, 0x0B)  # full resolution, 16 g
    for _ in range(2):
        chip.feel(10 * G, -1 * G)
    assert chip.get(0x30, 8) == bytes.fromhex("80 0B 000A 00FF 0000")
    assert chip.get(0x30) == b"\x00"
    chip.put(0x31, 0x01)  # 10 bit at 4 g
    for _ in range(2):
        chip.feel(G)
    assert chip.get(0x32, 2) == bytes.fromhex("8000")
