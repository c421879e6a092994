"""The ICM-20948's table against its data sheet."""

import pytest

from tests.fixtures.data_sheets import Sheet, assert_set_up_and_read_as_stated

SHEET = Sheet(
    "icm20948",
    address=0x68,
    identity_register=0x00,
    identity=b"\xea",
    set_up=[(0x7F, 0x00), (0x06, 0x01), (0x7F, 0x20), (0x10, 0x00), (0x11, 0x00), (0x14, 0x39), (0x7F, 0x00)],
    answer="01 4000 E000 0000",
)


def test_bytes_are_the_data_sheets(monkeypatch: pytest.MonkeyPatch) -> None:
    assert_set_up_and_read_as_stated(SHEET, monkeypatch)
