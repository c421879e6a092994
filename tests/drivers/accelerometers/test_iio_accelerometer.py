"""The kernel's accelerometers: a folder that looks like sysfs, and a pipe as the device file."""

import os
import struct
from collections.abc import Callable, Iterator
from math import isnan, nan, pi
from pathlib import Path
from typing import Any

import pytest

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.accelerometers.accelerometer import SampleStatus
from stillarm.drivers.accelerometers.iio_accelerometer import IioAccelerometer

SCALE = 0.000598  # m/s^2 a count, as the kernel's adxl345 and others state it
RECORD = struct.Struct("<3h2xq")  # three words, padding, time in ns


class Kernel:
    """The files of one device."""

    def __init__(self, root: Path, name: str = "adxl345", *, buffered: bool = True) -> None:
        self.sysfs, self.devices = root / "sys", root / "dev"
        self.folder = self.sysfs / "iio:device1"
        self.folder.mkdir(parents=True)
        self.devices.mkdir()
        files = {
            "name": name,
            "in_accel_scale": str(SCALE),
            "sampling_frequency": "1000",
            "in_accel_filter_low_pass_3db_frequency": "250.0",
            "in_accel_x_raw": "0",
            "in_accel_y_raw": "1000",
            "in_accel_z_raw": "-2000",
        }
        for file, text in files.items():
            (self.folder / file).write_text(text + "\n")
        other = self.sysfs / "iio:device0"
        other.mkdir()
        (other / "name").write_text("cpu-temperature\n")
        self.pipe = self.devices / "iio:device1"
        self._write_end = -1
        if buffered:
            self._make_buffer()

    def _make_buffer(self) -> None:
        elements = self.folder / "scan_elements"
        elements.mkdir()
        types = {"in_accel_x": 0, "in_accel_y": 1, "in_accel_z": 2, "in_anglvel_x": 3, "in_timestamp": 4}
        for channel, index in types.items():
            (elements / f"{channel}_en").write_text("1\n" if channel == "in_anglvel_x" else "0\n")
            (elements / f"{channel}_index").write_text(f"{index}\n")
            (elements / f"{channel}_type").write_text(
                "le:s64/64>>0\n" if channel == "in_timestamp" else "le:s13/16>>3\n"
            )
        (self.folder / "buffer").mkdir()
        (self.folder / "buffer" / "enable").write_text("0\n")
        (self.folder / "buffer" / "length").write_text("2\n")
        self.plug()

    def plug(self) -> None:
        os.mkfifo(self.pipe)
        self._write_end = os.open(self.pipe, os.O_RDWR | os.O_NONBLOCK)

    def unplug(self) -> None:
        self.pipe.unlink()
        os.close(self._write_end)
        self._write_end = -1

    def sample(self, x: int, y: int, z: int, time_ns: int = 0) -> None:
        os.write(self._write_end, RECORD.pack(x << 3, y << 3, z << 3, time_ns))

    def raw(self, data: bytes) -> None:
        os.write(self._write_end, data)

    def close(self) -> None:
        if self._write_end >= 0:
            os.close(self._write_end)


class Rig:
    """The files, the driver and its clock; a sample is there whenever start() waits."""

    def __init__(self, kernel: Kernel, **config: Any) -> None:
        self.kernel = kernel
        self.now_s = 50.0
        self.feed: Callable[[], None] | None = None
        settings: dict[str, Any] = {"device": "adxl345", **config}
        self.driver = IioAccelerometer(
            AccelerometerDevice(driver="iio", **settings),
            wait_s=0.1,
            sysfs=kernel.sysfs,
            devices=kernel.devices,
            sleep=self.sleep,
            clock=lambda: self.now_s,
        )

    def sleep(self, duration_s: float) -> None:
        self.now_s += duration_s
        if self.feed is not None:
            self.feed()


@pytest.fixture
def make(tmp_path: Path) -> Iterator[Callable[..., Rig]]:
    made: list[Rig] = []

    def build(*, buffered: bool = True, **config: Any) -> Rig:
        rig = Rig(Kernel(tmp_path, buffered=buffered), **config)
        if buffered:
            rig.feed = lambda: rig.kernel.sample(0, 0, 0)
        made.append(rig)
        return rig

    yield build
    for rig in made:
        rig.driver.close()
        rig.kernel.close()


@pytest.mark.parametrize("device", ["adxl345", "iio:device1"])
def test_a_buffer_is_switched_on_and_its_newest_record_taken(make: Callable[..., Rig], device: str) -> None:
    rig = make(device=device, axis="z", bias_m_s2=0.1)
    rig.driver.start()
    folder = rig.kernel.folder
    assert (folder / "buffer" / "enable").read_text() == "1"
    assert (folder / "scan_elements" / "in_accel_z_en").read_text() == "1"
    assert (folder / "scan_elements" / "in_anglvel_x_en").read_text() == "0"
    for count in range(10):
        rig.kernel.sample(1, 2, -300 * count, 1_000_000 * count)
    assert rig.driver.read() == pytest.approx(-2700 * SCALE - 0.1)
    reading = rig.driver.last_reading()
    assert reading.status == SampleStatus.FRESH
    assert reading.acceleration_xyz_m_s2 == pytest.approx((SCALE, 2 * SCALE, -2700 * SCALE))
    assert reading.device_time_s == pytest.approx(0.009)
    assert rig.driver.read() == pytest.approx(-2700 * SCALE - 0.1)
    assert rig.driver.last_reading().status == SampleStatus.HELD
    rig.driver.close()
    assert (folder / "buffer" / "enable").read_text() == "0"


def test_rate_delay_range_and_identity(make: Callable[..., Rig]) -> None:
    rig = make()
    rig.driver.start()
    assert rig.driver.rate_hz == 1000.0
    assert rig.driver.delay_s == pytest.approx(1.0 / (2.0 * pi * 250.0))
    assert rig.driver.range_m_s2 == pytest.approx(4096 * SCALE)
    assert rig.driver.identify() == "adxl345 (iio:device1), buffered"


def test_records_in_pieces(make: Callable[..., Rig]) -> None:
    rig = make()
    rig.driver.start()
    data = RECORD.pack(0, 500 << 3, 0, 0) + RECORD.pack(0, 600 << 3, 0, 0)
    seen = []
    for at in range(0, len(data), 5):
        rig.kernel.raw(data[at : at + 5])
        seen.append(round(rig.driver.read() / SCALE))
    assert seen == [0, 0, 0, 500, 500, 500, 600]


def test_without_a_buffer_the_files_are_read(make: Callable[..., Rig]) -> None:
    rig = make(buffered=False)
    rig.driver.start()
    assert rig.driver.identify().endswith("read one by one")
    assert rig.driver.read() == pytest.approx(1000 * SCALE)
    (rig.kernel.folder / "in_accel_y_raw").write_text("-1234\n")
    assert rig.driver.read() == pytest.approx(-1234 * SCALE)


def test_a_silent_buffer_runs_stale(make: Callable[..., Rig]) -> None:
    rig = make()
    rig.driver.start()
    rig.kernel.sample(0, 700, 0)
    assert rig.driver.read() == pytest.approx(700 * SCALE)
    rig.now_s += 0.0059
    assert rig.driver.read() == pytest.approx(700 * SCALE)
    rig.now_s += 0.0002
    assert isnan(rig.driver.read())
    assert rig.driver.last_reading().status == SampleStatus.STALE
    assert rig.driver.faults == 1


def test_unplugged_and_plugged_again(make: Callable[..., Rig]) -> None:
    rig = make()
    rig.driver.start()
    rig.kernel.unplug()
    for _ in range(100):
        rig.now_s += 0.001
        assert isnan(rig.driver.read())
    rig.kernel.plug()
    seen = []
    for count in range(400):
        rig.now_s += 0.001
        rig.kernel.sample(0, count, 0)
        seen.append(rig.driver.read())
    assert seen[-1] == pytest.approx(399 * SCALE)


def test_devices_that_are_none(make: Callable[..., Rig], tmp_path: Path) -> None:
    for device, words in (
        ("bma180", "iio:device0 (cpu-temperature), iio:device1 (adxl345)"),
        ("cpu-temperature", "not an accelerometer"),
    ):
        rig = Rig(Kernel(tmp_path / device), device=device)
        with pytest.raises(UserError) as caught:
            rig.driver.start()
        assert str(caught.value).startswith(f"accelerometer.device = {device!r}: ")
        assert words in str(caught.value)
        rig.kernel.close()


def test_no_sample_is_told(make: Callable[..., Rig]) -> None:
    rig = make()
    rig.feed = None
    with pytest.raises(UserError, match=r"^accelerometer\.device = [^\n]*trigger[^\n]*$"):
        rig.driver.start()
    with pytest.raises(RuntimeError, match="start"):
        rig.driver.read()


def test_before_start_there_is_nothing() -> None:
    driver = IioAccelerometer(AccelerometerDevice(driver="iio"))
    assert isnan(driver.last_reading().acceleration_xyz_m_s2[0])
    assert repr(driver.rate_hz) == repr(nan)
