"""The chip's registers, as its data sheet has them."""

import pytest

from tests.fixtures.register_chips import Chip, G


@pytest.mark.parametrize(("part", "address"), [("adxl355", 0x1D)])
def test_adxl355(part: str, address: int, chip: Chip) -> None:
    assert chip.get(0x00, 4) == bytes.fromhex("AD1DED01")
    assert chip.get(0x2D) == b"\x01"  # standby
    chip.put(0x2C, 0x82)
    chip.put(0x2D, 0x00)
    chip.put(0x28, 0x02)
    chip.feel(G, -G)
    assert chip.get(0x04, 13) == bytes.fromhex("01 03 0000 1F4000 E0C000 000000")
    assert chip.get(0x04)[0] & 0x01 == 0
    assert chip.get(0x11, 9) == bytes.fromhex("1F4001 E0C000 000000")  # the FIFO, with its marker on x
    assert chip.get(0x05) == b"\x00"
    chip.put(0x00, 0x12)
    assert chip.get(0x00) == b"\xad"
    chip.put(0x2F, 0x52)  # reset
    assert (chip.get(0x2C), chip.get(0x2D), chip.get(0x28)) == (b"\x81", b"\x01", b"\x00")
