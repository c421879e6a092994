"""The MPU-6050's table against its data sheet."""

import pytest

from stillarm.drivers.accelerometers.register_tables import TABLES
from tests.fixtures.data_sheets import Sheet, assert_set_up_and_read_as_stated

SHEET = Sheet(
    "mpu6050",
    address=0x68,
    identity_register=0x75,
    identity=b"\x68",
    set_up=[(0x6B, 0x01), (0x1A, 0x01), (0x19, 0x00), (0x1C, 0x00)],
    answer="01 4000 E000 0000",
    in_any_order=True,  # of filter, divider and range, behind the clock
)


def test_bytes_are_the_data_sheets(monkeypatch: pytest.MonkeyPatch) -> None:
    assert_set_up_and_read_as_stated(SHEET, monkeypatch)


def test_delays_are_those_stated() -> None:
    assert {f.bandwidth_hz: pytest.approx(f.delay_s, rel=0.01) for f in TABLES["mpu6050"].filters} == {
        260.0: 0.612e-3,  # stated as 0, which no filter of 260 Hz can have
        184.0: 2.0e-3,
        94.0: 3.0e-3,
        44.0: 4.9e-3,
    }
