"""The LIS3DH's table against its data sheet."""

import pytest

from tests.fixtures.data_sheets import Sheet, assert_set_up_and_read_as_stated

SHEET = Sheet(
    "lis3dh",
    address=0x18,
    identity_register=0x0F,
    identity=b"\x33",
    set_up=[(0x23, 0x88), (0x20, 0x97)],
    answer="0F 803E C0E0 0000",  # 1000 counts of 12 bit = 0x3E80 left-justified
)


def test_bytes_are_the_data_sheets(monkeypatch: pytest.MonkeyPatch) -> None:
    assert_set_up_and_read_as_stated(SHEET, monkeypatch)
