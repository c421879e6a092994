"""An accelerometer with a Linux kernel driver (industrial I/O): files in sysfs, and a buffer as a device file.

With a buffer the kernel samples by its trigger, and a read takes the samples that have arrived. Without a buffer each
read queries the device itself, which takes as long as its bus needs. Source: the kernel's ABI document sysfs-bus-iio.
"""

import os
import time
from collections.abc import Callable
from math import nan
from pathlib import Path

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.common.user_error import UserError, reason_of
from stillarm.drivers.accelerometers.accelerometer import Reading, SampleStatus
from stillarm.drivers.accelerometers.iio_record import IioRecord, read_layout
from stillarm.drivers.accelerometers.mounting import measured_direction
from stillarm.drivers.accelerometers.register_tables.register_table import first_order_delay_s

_KEY = "accelerometer.device"
_AXES = ("in_accel_x", "in_accel_y", "in_accel_z")
_BUFFERED_RECORDS = 64
_STALE_S = 0.006
_STALE_PERIODS = 3.0  # sample periods of a slow device, after which its last sample is no longer used
_LOOK_AGAIN_S = 0.25
_POLL_S = 0.001
_NO_NUMBERS = (nan, nan, nan)


class IioAccelerometer:
    """One axis of the accelerometer; implements stillarm.drivers.accelerometers.accelerometer.Accelerometer."""

    def __init__(
        self,
        config: AccelerometerDevice,
        *,
        wait_s: float = 10.0,
        sysfs: Path = Path("/sys/bus/iio/devices"),
        devices: Path = Path("/dev"),
        sleep: Callable[[float], None] = time.sleep,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Opens nothing. Range, filter and rate are those set in the kernel driver's files."""
        self.delay_s = 0.0  # until the kernel states a bandwidth
        self.rate_hz = nan
        self.range_m_s2 = nan
        self.faults = 0
        self._config = config
        self._wait_s = wait_s
        self._sysfs, self._devices = sysfs, devices
        self._sleep, self._clock = sleep, clock
        self._weights = measured_direction(config)
        self._files: list[int] = []
        self._record: IioRecord | None = None
        self._started = False
        self._rest = b""
        self._scales, self._offsets = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
        self._xyz = _NO_NUMBERS
        self._stamp_s = self._read_s = nan
        self._arrived_s = self._not_before_s = 0.0
        self._stale_s = _STALE_S
        self._status = SampleStatus.SETTING_UP

    def start(self) -> None:
        """Find the device, switch on its buffer if it has one, wait for a sample. Raises UserError with a remedy."""
        self.close()
        self._started = True
        try:
            self._open()
            self._await_sample()
        except OSError as error:
            self.close()
            raise UserError(
                f"{_KEY} = {self._config.device!r}: {error.filename or 'the device'} failed "
                f"({reason_of(error)}); run as a user who may write there (a udev rule for iio), "
                "and check that the kernel driver has a trigger (trigger/current_trigger)"
            ) from None
        except UserError:
            self.close()
            raise
        self.faults = 0

    def identify(self) -> str:
        """The kernel's name of the device, and how it is read. Raises UserError if it is gone."""
        folder = self._folder()
        return (
            f"{_text(folder / 'name')} ({folder.name}), {'buffered' if self._record else 'read one by one'}"
        )

    def read(self) -> float:
        """The newest acceleration along the configured axis, m/s^2; NaN (and counted) if there is none."""
        if not self._started:
            raise RuntimeError("read() before start()")
        now = self._read_s = self._clock()
        if not self._files and not self._opened_again(now):
            return self._missing(SampleStatus.NO_ANSWER)
        try:
            fresh = self._take_buffered() if self._record else self._take_one()
        except OSError:
            self._release()
            self._not_before_s = now + _LOOK_AGAIN_S
            return self._missing(SampleStatus.NO_ANSWER)
        if fresh:
            self._arrived_s, self._status = now, SampleStatus.FRESH
        elif now - self._arrived_s > self._stale_s or self._xyz[0] != self._xyz[0]:
            return self._missing(SampleStatus.STALE)
        else:
            self._status = SampleStatus.HELD
        return sum(w * a for w, a in zip(self._weights, self._xyz, strict=True)) - self._config.bias_m_s2

    def last_reading(self) -> Reading:
        """The details of the last read()."""
        there = self._status in (SampleStatus.FRESH, SampleStatus.HELD)
        return Reading(self._xyz if there else _NO_NUMBERS, self._status, -1, self._read_s, self._stamp_s)

    def close(self) -> None:
        """Switch the buffer off and release the files; may be called twice."""
        buffered = self._record is not None and bool(self._files)
        self._release()
        self._started = False
        if buffered:
            try:
                _write(self._folder() / "buffer" / "enable", "0")
            except (OSError, UserError):  # gone
                return

    def _take_buffered(self) -> bool:
        assert self._record is not None
        size = self._record.size
        try:
            data = os.read(self._files[0], _BUFFERED_RECORDS * size)
        except BlockingIOError:
            return False
        if not data:  # the buffer has ended: the device is gone
            raise OSError("end of the buffer")
        data = self._rest + data
        whole = len(data) // size * size
        self._rest = data[whole:]
        if not whole:
            return False
        counts, self._stamp_s = self._record.decode(data[whole - size : whole])
        self._convert(counts)
        return True

    def _take_one(self) -> bool:
        self._convert([float(os.pread(file, 32, 0)) for file in self._files])
        return True

    def _convert(self, counts: list[float]) -> None:
        x, y, z = (
            (c + offset) * scale for c, offset, scale in zip(counts, self._offsets, self._scales, strict=True)
        )
        self._xyz = x, y, z

    def _open(self) -> None:
        folder = self._folder()
        self._scales = _three(folder, "scale", 1.0)
        self._offsets = _three(folder, "offset", 0.0)
        self.rate_hz = _number(folder, ("sampling_frequency", "in_accel_sampling_frequency"), nan)
        bandwidth_hz = _number(folder, ("in_accel_filter_low_pass_3db_frequency",), nan)
        self.delay_s = first_order_delay_s(bandwidth_hz) if bandwidth_hz > 0.0 else 0.0
        self._stale_s = max(_STALE_S, _STALE_PERIODS / self.rate_hz) if self.rate_hz > 0.0 else _STALE_S
        self._rest, self._xyz, self._arrived_s = b"", _NO_NUMBERS, self._clock()
        device = self._devices / folder.name
        if (folder / "scan_elements").is_dir() and device.exists():
            self._open_buffer(folder, device)
            return
        self._record = None
        self._files = [os.open(folder / f"{axis}_raw", os.O_RDONLY) for axis in _AXES]

    def _open_buffer(self, folder: Path, device: Path) -> None:
        buffer, elements = folder / "buffer", folder / "scan_elements"
        _write(buffer / "enable", "0")
        for switch in elements.glob("*_en"):
            _write(switch, "1" if switch.name[:-3] in (*_AXES, "in_timestamp") else "0")
        if (buffer / "length").exists():
            _write(buffer / "length", str(_BUFFERED_RECORDS))
        self._record = read_layout(elements, _AXES)
        self.range_m_s2 = min(
            abs(scale) * limit for scale, limit in zip(self._scales, self._record.limits, strict=True)
        )
        _write(buffer / "enable", "1")
        self._files = [os.open(device, os.O_RDONLY | os.O_NONBLOCK)]

    def _opened_again(self, now: float) -> bool:
        if now < self._not_before_s:
            return False
        self._not_before_s = now + _LOOK_AGAIN_S
        try:
            self._open()
        except (OSError, UserError, ValueError):
            self._release()
            return False
        return True

    def _folder(self) -> Path:
        wanted = self._config.device
        for folder in sorted(self._sysfs.glob("iio:device*")):
            if wanted in (folder.name, _text(folder / "name")):
                if not (folder / "in_accel_x_raw").exists() and not (folder / "scan_elements").is_dir():
                    raise UserError(
                        f"{_KEY} = {wanted!r}: {folder.name} is not an accelerometer; name another device"
                    )
                return folder
        found = ", ".join(f"{f.name} ({_text(f / 'name')})" for f in sorted(self._sysfs.glob("iio:device*")))
        raise UserError(
            f"{_KEY} = {wanted!r}: no such industrial I/O device; "
            + (f"there are {found}" if found else "there are none: load the sensor's kernel driver")
        )

    def _missing(self, status: SampleStatus) -> float:
        self.faults += 1
        self._status = status
        return nan

    def _release(self) -> None:
        for file in self._files:
            os.close(file)
        self._files = []

    def _await_sample(self) -> None:
        for _ in range(max(1, round(self._wait_s / _POLL_S))):
            self.read()
            if self._status == SampleStatus.FRESH:
                return
            self._sleep(_POLL_S)
        raise UserError(
            f"{_KEY} = {self._config.device!r}: no sample arrived in {self._wait_s:g} s; "
            "set a trigger (trigger/current_trigger) and a sampling frequency"
        )


def _text(path: Path) -> str:
    try:
        return path.read_text().strip()
    except OSError:
        return ""


def _write(path: Path, text: str) -> None:
    path.write_text(text)


def _number(folder: Path, names: tuple[str, ...], default: float) -> float:
    for name in names:
        text = _text(folder / name)
        if text:
            return float(text.split()[0])
    return default


def _three(folder: Path, what: str, default: float) -> tuple[float, float, float]:
    x, y, z = (_number(folder, (f"{axis}_{what}", f"in_accel_{what}"), default) for axis in _AXES)
    return x, y, z
