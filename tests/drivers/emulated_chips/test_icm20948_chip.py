"""The chip's registers, as its data sheet has them."""

import pytest

from tests.fixtures.register_chips import Chip, G


@pytest.mark.parametrize(("part", "address"), [("icm20948", 0x68)])
def test_icm20948(part: str, address: int, chip: Chip) -> None:
    assert chip.get(0x00) == b"\xea"
    chip.put(0x06, 0x01)
    chip.put(0x11, 0x01)
    chip.put(0x7F, 0x20)
    assert chip.get(0x00) == b"\x00"  # another bank
    chip.put(0x14, 0x03)  # 4 g
    chip.put(0x11, 0x00)
    chip.put(0x7F, 0x00)
    assert chip.get(0x11) == b"\x01"
    chip.feel(G, -G)
    assert chip.get(0x1A) == b"\x01"
    assert chip.get(0x2D, 6) == bytes.fromhex("2000 E000 0000")
    assert chip.get(0x1A) == b"\x00"
