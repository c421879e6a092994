"""The driver of every serial accelerometer: it reads a table of serial_devices.py.

In each cycle the driver reads at most 1 KiB of the bytes that have arrived, and returns the newest sample. It reopens a
port that disappears, and sets up a silent or slow device again, one command a read.
"""

import time
from collections.abc import Callable
from math import isfinite, nan
from pathlib import Path

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.accelerometers.accelerometer import Reading, SampleStatus
from stillarm.drivers.accelerometers.mounting import measured_direction
from stillarm.drivers.accelerometers.serial_decoders.framing import FrameDecoder, SerialSample
from stillarm.drivers.accelerometers.serial_devices import SerialDevice
from stillarm.drivers.buses.serial_port import PTY_PREFIX, PortLost, SerialPort, port_path

_KEY = "accelerometer.port"
_MOST_BYTES = 1024  # per read: 40 ms of the densest stream; older data are useless to the loop
_STALE_PERIODS = 3.0  # sample periods of a slow device, after which its last sample is no longer used
_STALE_S = 0.006
_WATCHED_S, _ENOUGH = 0.5, 0.4  # s, fraction: tolerates half the rate, to avoid endless set-ups
_LOOK_AGAIN_S = 0.25
_POLL_S = 0.001
_NO_NUMBERS = (nan, nan, nan)


class SerialAccelerometer:
    """One axis of the accelerometer; implements stillarm.drivers.accelerometers.accelerometer.Accelerometer."""

    def __init__(
        self,
        config: AccelerometerDevice,
        device: SerialDevice,
        *,
        wait_s: float = 10.0,
        sleep: Callable[[float], None] = time.sleep,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Opens nothing. wait_s: how long start() waits for an emulated port, and then for a sample.

        With 0 it waits for neither, and the reads set up the device; use 0 if nothing advances during start().
        """
        self.delay_s = device.delay_s
        self.rate_hz = device.rate_hz
        self.range_m_s2 = device.range_m_s2
        self.faults = 0
        self._config = config
        self._device = device
        self._wait_s = wait_s
        self._sleep = sleep
        self._clock = clock
        self._weights = measured_direction(config)
        self._decoder = FrameDecoder(device.framing)
        self._port: SerialPort | None = None
        self._started = False
        self._commands_left = 0
        self._not_before_s = 0.0
        self._watched_since_s, self._watched_samples = 0.0, 0
        self._bytes = 0
        self._newest: SerialSample | None = None
        self._arrived_s = self._read_s = nan
        self._status = SampleStatus.SETTING_UP
        self._stale_s = max(_STALE_S, _STALE_PERIODS / device.rate_hz)

    def start(self) -> None:
        """Open the port, set up the device, wait for samples. Raises UserError with a remedy."""
        self.close()
        self._await_port()
        self._started = True
        self._open()
        try:
            if self._wait_s > 0.0:
                self._await_sample()
        except UserError:
            self.close()
            raise
        self.faults = 0

    def identify(self) -> str:
        """The number of frames so far, in words. Raises RuntimeError before start()."""
        self._check_started()
        return (
            f"{self._device.name} on {self._config.port}: {self._decoder.frames} frames received, "
            f"{self._decoder.rejected} false starts of frames"
        )

    def read(self) -> float:
        """The newest acceleration along the configured axis, m/s^2; NaN (and counted) if there is none.

        There is none if the port is gone or no sample has arrived for 6 ms, or three periods of a slow device. Raises
        RuntimeError before start().
        """
        self._check_started()
        now = self._read_s = self._clock()
        if self._port is None and not self._reopened(now):
            return self._missing(SampleStatus.NO_ANSWER)
        try:
            samples = self._take(now)
        except PortLost:
            self._let_go(now)
            return self._missing(SampleStatus.NO_ANSWER)
        if samples:
            self._newest, self._arrived_s, self._status = samples[-1], now, SampleStatus.FRESH
        elif self._newest is None or now - self._arrived_s > self._stale_s:
            return self._missing(SampleStatus.STALE if self._commands_left == 0 else SampleStatus.SETTING_UP)
        else:
            self._status = SampleStatus.HELD
        x, y, z = self._weights
        newest = self._newest
        value = x * newest.x_m_s2 + y * newest.y_m_s2 + z * newest.z_m_s2 - self._config.bias_m_s2
        return value if isfinite(value) else self._missing(SampleStatus.IMPLAUSIBLE)

    def last_reading(self) -> Reading:
        """The details of the last read()."""
        newest = self._newest
        if newest is None or self._status not in (SampleStatus.FRESH, SampleStatus.HELD):
            return Reading(_NO_NUMBERS, self._status, -1, self._read_s, nan)
        xyz = newest.x_m_s2, newest.y_m_s2, newest.z_m_s2
        return Reading(xyz, self._status, newest.status, self._read_s, newest.time_s)

    def close(self) -> None:
        """Release the port; may be called twice."""
        if self._port is not None:
            self._port.close()
        self._port = None
        self._started = False

    def _check_started(self) -> None:
        if not self._started:
            raise RuntimeError("read() before start()")

    def _take(self, now: float) -> list[SerialSample]:
        assert self._port is not None
        data = self._port.read()
        self._bytes += len(data)
        samples = self._decoder.feed(data[-_MOST_BYTES:]) if data else []
        self._watch_rate(len(samples), now)
        if self._commands_left and now >= self._not_before_s:
            command = self._device.set_up[-self._commands_left]
            self._port.write(command.data)
            self._commands_left -= 1
            self._not_before_s = self._watched_since_s = now + command.wait_s
        told = self._decoder.description
        if told is not None:
            self._decoder.description = None
            self.rate_hz, self.range_m_s2 = told.rate_hz, told.range_m_s2
            self.delay_s = told.delay_s + self._device.delay_s
        return samples

    def _watch_rate(self, samples: int, now: float) -> None:
        """Set up the device again if it delivers too few samples, as after a loss of power and settings."""
        if self._commands_left:
            self._watched_samples = 0
            return
        self._watched_samples += samples
        watched_s = now - self._watched_since_s
        if watched_s < _WATCHED_S:
            return
        if self._watched_samples < _ENOUGH * watched_s * self.rate_hz:
            self._commands_left = len(self._device.set_up)
            self._not_before_s = now
        self._watched_since_s, self._watched_samples = now, 0

    def _open(self) -> None:
        """Open the port. Old data in it are discarded, read by read. Raises UserError."""
        self._port = SerialPort(self._config.port, self._config.baud or self._device.baud, _KEY)
        self._decoder.clear()
        self._newest = None
        self._commands_left = len(self._device.set_up)
        self._arrived_s = self._not_before_s = self._watched_since_s = self._clock()
        self._watched_samples = 0

    def _reopened(self, now: float) -> bool:
        if now < self._not_before_s:
            return False
        self._not_before_s = now + _LOOK_AGAIN_S
        if not Path(port_path(self._config.port)).exists():
            return False
        try:
            self._open()
        except UserError:
            return False
        return True

    def _let_go(self, now: float) -> None:
        if self._port is not None:
            self._port.close()
        self._port = None
        self._newest = None
        self._not_before_s = now + _LOOK_AGAIN_S

    def _missing(self, status: SampleStatus) -> float:
        self.faults += 1
        self._status = status
        return nan

    def _await_port(self) -> None:
        name = self._config.port
        if not name.startswith(PTY_PREFIX):
            return
        for _ in range(round(self._wait_s / _POLL_S)):
            if Path(port_path(name)).exists():
                return
            self._sleep(_POLL_S)

    def _await_sample(self) -> None:
        waits = sum(command.wait_s for command in self._device.set_up)
        for _ in range(round((self._wait_s + waits) / _POLL_S)):
            self.read()
            if self._status == SampleStatus.FRESH and not self._commands_left:
                return
            self._sleep(_POLL_S)
        device, place = self._device, f"{_KEY} = {self._config.port!r}"
        if self._bytes and not self._decoder.frames:
            raise UserError(
                f"{place}: {self._bytes} bytes arrived, but no frame of a {device.name}; correct "
                f"accelerometer.driver, or accelerometer.baud (now {self._config.baud or device.baud})"
            )
        raise UserError(
            f"{place}: the {device.name} gives no samples {self._wait_s:g} s after its set-up; "
            "check its cable, its power and accelerometer.baud; with a simulated rig, check that it runs"
        )
