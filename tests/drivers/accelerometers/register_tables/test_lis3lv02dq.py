"""The LIS3LV02DQ's table against its data sheet."""

import pytest

from tests.fixtures.data_sheets import Sheet, assert_set_up_and_read_as_stated

SHEET = Sheet(
    "lis3lv02dq",
    address=0x1D,
    identity_register=0x0F,
    identity=b"\x3a",
    set_up=[(0x21, 0x44), (0x20, 0xF7)],
    answer="0F 0004 00FE 0000",
)


def test_bytes_are_the_data_sheets(monkeypatch: pytest.MonkeyPatch) -> None:
    assert_set_up_and_read_as_stated(SHEET, monkeypatch)
