"""The ADXL345's table against its data sheet."""

import pytest

from tests.fixtures.data_sheets import Sheet, assert_set_up_and_read_as_stated

SHEET = Sheet(
    "adxl345",
    address=0x53,
    identity_register=0x00,
    identity=b"\xe5",
    set_up=[(0x2D, 0x00), (0x31, 0x08), (0x2C, 0x0D), (0x38, 0x00), (0x2D, 0x08)],
    answer="80 08 0001 80FF 0000",
)


def test_bytes_are_the_data_sheets(monkeypatch: pytest.MonkeyPatch) -> None:
    assert_set_up_and_read_as_stated(SHEET, monkeypatch)
