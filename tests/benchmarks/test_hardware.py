"""The table of what reads cost: a row for every device, with finite numbers."""

from stillarm.benchmarks import hardware
from stillarm.drivers.accelerometers.register_tables import TABLES
from stillarm.drivers.accelerometers.serial_devices import SERIAL_DEVICES


def test_a_row_for_every_accelerometer() -> None:
    reads, hardware._READS = hardware._READS, 30
    try:
        rows = hardware.run(1, 0)["rows"]
    finally:
        hardware._READS = reads
    assert [row["driver"] for row in rows] == [*TABLES, *SERIAL_DEVICES]
    for row in rows:
        assert 0.0 < row["us_per_read"] <= row["us_per_read_p99"]
        assert (row["bus_us"] is None) == (row["driver"] in SERIAL_DEVICES)
    by_name = {row["driver"]: row for row in rows}
    # Seven bytes after two address bytes and a register: 10 bytes of 9 bits at 400 kHz.
    assert by_name["lis3dh"]["bus_us"] == 225.0
    assert by_name["adxl355"]["bus_us"] == 360.0
