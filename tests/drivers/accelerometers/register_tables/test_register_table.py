"""The tables against the data sheets: bytes written and numbers read, as literals from sources of their own."""

from pathlib import Path
from typing import Any

import pytest

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.drivers.accelerometers.i2c_accelerometer import I2cAccelerometer
from stillarm.drivers.accelerometers.register_tables import TABLES
from stillarm.drivers.accelerometers.serial_devices import SERIAL_DEVICES

# part: address, identity register and bytes, and what of the set-up for +-2 g decides (register, value), in order
FACTS: dict[str, tuple[int, int, bytes, list[tuple[int, int]]]] = {
    "lis3lv02dq": (0x1D, 0x0F, b"\x3a", [(0x21, 0x44), (0x20, 0xF7)]),
    "lis3dh": (0x18, 0x0F, b"\x33", [(0x23, 0x88), (0x20, 0x97)]),
    "adxl345": (0x53, 0x00, b"\xe5", [(0x2D, 0), (0x31, 0x08), (0x2C, 0x0D), (0x38, 0), (0x2D, 0x08)]),
    "adxl355": (0x1D, 0x00, b"\xad\x1d\xed", [(0x2F, 0x52), (0x28, 0x02), (0x2C, 0x81), (0x2D, 0)]),
    "mpu6050": (0x68, 0x75, b"\x68", [(0x6B, 1), (0x1A, 1), (0x19, 0), (0x1C, 0)]),
    "icm20948": (
        0x68,
        0x00,
        b"\xea",
        [(0x7F, 0), (0x06, 1), (0x7F, 0x20), (0x10, 0), (0x11, 0), (0x14, 0x39), (0x7F, 0)],
    ),
}
# part: what the device answers to one transfer, and x, y, z in m/s^2: +1 g, -1/2 g, 0
G = 9.80665
ANSWERS: dict[str, tuple[str, float]] = {
    "lis3lv02dq": ("0F 0004 00FE 0000", 1e-6),
    "lis3dh": ("0F 803E C0E0 0000", 1e-6),  # 1000 counts of 12 bit = 0x3E80 left-justified
    "adxl345": ("80 08 0001 80FF 0000", 1e-6),
    "adxl355": ("01 00 0000 3E8000 E0C000 000000", 1e-6),
    "mpu6050": ("01 4000 E000 0000", 1e-6),
    "icm20948": ("01 4000 E000 0000", 1e-6),
}


class Bus:
    """Records what is written; answers one transfer with given bytes."""

    def __init__(self, identity: bytes, answer: bytes) -> None:
        self.identity, self.answer = identity, answer
        self.written: list[tuple[int, int, int]] = []
        self.asked: list[tuple[int, int]] = []

    def write_byte_data(self, address: int, register: int, value: int) -> None:
        self.written.append((address, register, value))

    def i2c_rdwr(self, *messages: Any) -> None:
        answer = (
            self.answer if len(self.answer) == sum(m.len for m in messages if m.flags & 1) else self.identity
        )
        for write, read in zip(messages[::2], messages[1::2], strict=True):
            self.asked.append((next(iter(write)), read.len))
            for index in range(read.len):
                read.buf[index] = answer[index : index + 1]
            answer = answer[read.len :]

    def close(self) -> None: ...


@pytest.fixture
def bus(part: str, monkeypatch: pytest.MonkeyPatch) -> Bus:
    made = Bus(FACTS[part][2], bytes.fromhex(ANSWERS[part][0]))
    monkeypatch.setattr("stillarm.drivers.accelerometers.i2c_accelerometer.open_bus", lambda *_, **__: made)
    return made


@pytest.mark.parametrize("part", sorted(FACTS))
def test_set_up_is_the_data_sheets(part: str, bus: Bus) -> None:
    address, register, _, decisive = FACTS[part]
    now = iter(range(1000))
    driver = I2cAccelerometer(
        AccelerometerDevice(driver=part),  # type: ignore[arg-type]
        TABLES[part],
        wait_s=0.0,
        sleep=lambda _: None,
        clock=lambda: float(next(now)),
    )
    driver.start()
    assert all(at == address for at, _, _ in bus.written)
    written = [(register, value) for _, register, value in bus.written]
    rest = iter(written)
    if part == "mpu6050":  # the order of filter, divider and range does not matter
        assert set(decisive) <= set(written) and written[0] == (0x6B, 1)
    else:
        assert all(each in rest for each in decisive), written
    assert bus.asked[0][0] & 0x7F == register & 0x7F


@pytest.mark.parametrize("part", sorted(FACTS))
def test_bytes_become_the_acceleration(part: str, bus: Bus) -> None:
    driver = I2cAccelerometer(
        AccelerometerDevice(driver=part, axis="x"),  # type: ignore[arg-type]
        TABLES[part],
        wait_s=0.0,
        sleep=lambda _: None,
    )
    driver.start()
    assert driver.read() == pytest.approx(G, abs=ANSWERS[part][1])
    assert driver.last_reading().acceleration_xyz_m_s2 == pytest.approx(
        (G, -0.5 * G, 0.0), abs=ANSWERS[part][1]
    )


def test_delays_that_data_sheets_state() -> None:
    assert {f.bandwidth_hz: pytest.approx(f.delay_s, rel=0.01) for f in TABLES["mpu6050"].filters} == {
        260.0: 0.612e-3,  # stated as 0, which no filter of 260 Hz can have
        184.0: 2.0e-3,
        94.0: 3.0e-3,
        44.0: 4.9e-3,
    }
    for setting in TABLES["adxl355"].filters:
        periods = {4000.0: 2.52, 2000.0: 2.00, 1000.0: 1.78, 500.0: 1.63}[setting.rate_hz]
        assert setting.delay_s == pytest.approx(periods / setting.rate_hz, rel=0.01)


@pytest.mark.parametrize("part", sorted(FACTS))
def test_filters_delay_more_the_narrower_they_are(part: str) -> None:
    filters = sorted(TABLES[part].filters, key=lambda f: f.bandwidth_hz)
    delays = [f.delay_s for f in filters]
    assert delays == sorted(delays, reverse=True)
    assert TABLES[part].filters[0].rate_hz >= (800.0 if part == "adxl345" else 1000.0)


def test_the_document_says_what_the_tables_say() -> None:
    """Rate, filters, delay and ranges of every I2C part in docs/hardware_accelerometers.md."""
    text = (Path(__file__).parents[4] / "docs" / "hardware_accelerometers.md").read_text()
    rows = {
        cells[0]: cells
        for line in text.splitlines()
        if len(cells := [cell.strip() for cell in line.strip("|").split("|")]) == 9
    }
    for name, table in TABLES.items():
        _, bus, rate, filters, delay, ranges, *_ = rows[name]
        assert bus == "I2C"
        assert float(rate) == table.filters[0].rate_hz
        assert [float(f) for f in filters.split(",")] == [f.bandwidth_hz for f in table.filters]
        assert float(delay.split()[0]) == pytest.approx(1e3 * table.filters[0].delay_s, abs=0.006)
        assert [int(g) for g in ranges.split(",")] == list(table.full_scales)
    for name, device in SERIAL_DEVICES.items():
        assert float(rows[name][2]) == device.rate_hz
        assert float(rows[name][4].split()[0]) == pytest.approx(1e3 * device.delay_s, abs=0.006)
