"""The ADXL355's table against its data sheet."""

import pytest

from stillarm.drivers.accelerometers.register_tables import TABLES
from tests.fixtures.data_sheets import Sheet, assert_set_up_and_read_as_stated

SHEET = Sheet(
    "adxl355",
    address=0x1D,
    identity_register=0x00,
    identity=b"\xad\x1d\xed",
    set_up=[(0x2F, 0x52), (0x28, 0x02), (0x2C, 0x81), (0x2D, 0x00)],
    answer="01 00 0000 3E8000 E0C000 000000",
)


def test_bytes_are_the_data_sheets(monkeypatch: pytest.MonkeyPatch) -> None:
    assert_set_up_and_read_as_stated(SHEET, monkeypatch)


def test_delays_are_those_stated() -> None:
    for setting in TABLES["adxl355"].filters:
        periods = {4000.0: 2.52, 2000.0: 2.00, 1000.0: 1.78, 500.0: 1.63}[setting.rate_hz]
        assert setting.delay_s == pytest.approx(periods / setting.rate_hz, rel=0.01)
