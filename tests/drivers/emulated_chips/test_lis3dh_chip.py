"""The chip's registers, as its data sheet has them."""

import pytest

from tests.fixtures.register_chips import Chip, G


@pytest.mark.parametrize(("part", "address"), [("lis3dh", 0x18)])
def test_lis3dh(part: str, address: int, chip: Chip) -> None:
    assert chip.get(0x0F) == b"\x33"
    chip.feel(G)
    assert chip.get(0xA7, 7) == bytes(7)  # powered down
    chip.put(0x20, 0x97)
    chip.put(0x23, 0x88)
    chip.feel(G)
    assert chip.get(0xA7, 7) == bytes.fromhex("0F 803E 0000 0000")
    assert chip.get(0xA7, 1) == b"\x00"  # read
    chip.feel(G)
    chip.feel(G)
    assert chip.get(0x27) == b"\xff"  # overrun
    chip.put(0x23, 0x80)  # normal mode: 10 bit
    chip.feel(G)
    assert chip.get(0xA8, 2) == bytes.fromhex("803E")
    chip.put(0x23, 0xB8)  # 16 g: 12 mg a count
    chip.feel(G)
    assert chip.get(0xA8, 2) == (round(1000 / 12) << 4).to_bytes(2, "little")
