"""What holds for every table, and for the page about them."""

from pathlib import Path

import pytest

from stillarm.drivers.accelerometers.register_tables import TABLES
from stillarm.drivers.accelerometers.serial_devices import SERIAL_DEVICES

SLOWER_HZ = {"adxl345": 800.0}  # than the loop


@pytest.mark.parametrize("part", sorted(TABLES))
def test_filters_delay_more_the_narrower_they_are(part: str) -> None:
    filters = sorted(TABLES[part].filters, key=lambda f: f.bandwidth_hz)
    delays = [f.delay_s for f in filters]
    assert delays == sorted(delays, reverse=True)
    assert TABLES[part].filters[0].rate_hz >= SLOWER_HZ.get(part, 1000.0)


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
