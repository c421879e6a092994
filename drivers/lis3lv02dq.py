"""The paper's accelerometer, ST's LIS3LV02DQ, on an I2C bus.

Its registers stand in a table, so that a device which differs by its table only needs no driver of its own.
"""

import struct
import time
from collections.abc import Callable
from ctypes import create_string_buffer
from dataclasses import dataclass
from math import nan, pi

import smbus2

from common.configuration import AccelerometerDevice
from common.user_error import UserError
from drivers.accelerometer import STANDARD_GRAVITY_M_S2
from drivers.i2c import open_bus

_READ = 0x0001  # I2C_M_RD
_STALE_AFTER_READS = 5
_SET_UP_AGAIN_AFTER_READS = 500
_POLL_S = 0.001


@dataclass(frozen=True)
class RegisterTable:
    """What one transfer and a set-up need to know of an accelerometer whose status register precedes its
    data.

    set_up, counts_per_g: by full scale in g; set_up in the order of writing. max_count: largest magnitude
    that a sample can have. start_up_s: from power-up to valid data. delay_s: group delay of the filter that
    set_up chooses.
    """

    name: str
    identity_register: int
    identity: int
    set_up: dict[int, tuple[tuple[int, int], ...]]
    auto_increment: int
    status_register: int
    ready_mask: int
    layout: struct.Struct
    counts_per_g: dict[int, int]
    max_count: int
    start_up_s: float
    delay_s: float


LIS3LV02DQ = RegisterTable(
    name="LIS3LV02DQ",
    identity_register=0x0F,
    identity=0x3A,
    # CTRL2: range, block data update, data-ready; CTRL1: power on, 2560 Hz, all axes
    set_up={2: ((0x21, 0x44), (0x20, 0xF7)), 6: ((0x21, 0xC4), (0x20, 0xF7))},
    auto_increment=0x80,
    status_register=0x27,
    ready_mask=0x08,
    layout=struct.Struct("<B3h"),
    counts_per_g={2: 1024, 6: 340},
    max_count=2048,
    start_up_s=5.0 / 2560.0,
    # bandwidth: a quarter of the rate, 640 Hz; taken as a first-order lag's, no group delay being stated
    delay_s=1.0 / (2.0 * pi * 640.0),
)


class Lis3lv02dq:
    """One axis of the accelerometer; implements drivers.accelerometer.Accelerometer."""

    def __init__(
        self,
        config: AccelerometerDevice,
        table: RegisterTable = LIS3LV02DQ,
        *,
        wait_s: float = 10.0,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Opens nothing. wait_s: how long start() waits for an emulated bus to appear, and then for a first
        sample.

        With wait_s = 0, as in virtual time, where nothing moves during start(), it waits for neither.
        """
        self.delay_s = table.delay_s
        self.faults = 0
        self._config = config
        self._table = table
        self._wait_s = wait_s
        self._sleep = sleep
        self._axis = "xyz".index(config.axis)
        self._m_s2_per_count = STANDARD_GRAVITY_M_S2 / table.counts_per_g[config.full_scale_g]
        self._bus: smbus2.SMBus | None = None
        self._data = create_string_buffer(table.layout.size)
        self._floating = b"\xff" * table.layout.size
        self._request = smbus2.i2c_msg.write(config.address, [table.status_register | table.auto_increment])
        self._answer = smbus2.i2c_msg(addr=config.address, flags=_READ, len=table.layout.size, buf=self._data)
        self._last = nan
        self._without_data = 0

    def start(self) -> None:
        """Open the bus, check the identity, set rate and range, wait until samples come.

        Raises UserError with a remedy: for a bus that cannot be opened, a device that does not answer,
        another device, or one that gives no samples.
        """
        self.close()
        self._bus = open_bus(self._config.bus, wait_s=self._wait_s)
        try:
            self._check_identity(self._bus)
            self._set_up(self._bus)
            self._sleep(self._table.start_up_s)
            if self._wait_s > 0.0:
                self._await_sample()
        except OSError as error:
            self.close()
            raise UserError(
                f"{self._place}: no {self._table.name} answers ({(error.strerror or str(error)).lower()}); "
                "check power and wiring, or correct accelerometer.address "
                "(`i2cdetect -y N` lists what answers on bus N)"
            ) from None
        except UserError:
            self.close()
            raise
        self.faults = 0

    def read(self) -> float:
        """The newest acceleration along the configured axis, m/s^2; NaN (and counted) where there is none.

        There is none when the bus does not answer, when the bytes cannot be samples, or when no data became
        ready in more than 5 reads; up to then the last sample stands. After 500 reads without data the
        device is set up
        again: it may have lost its power. Raises RuntimeError before start().
        """
        bus = self._bus
        if bus is None:
            raise RuntimeError("read() before start()")
        table = self._table
        try:
            bus.i2c_rdwr(self._request, self._answer)
        except OSError:
            return self._missing(bus)
        status, *counts = table.layout.unpack_from(self._data)
        if not status & table.ready_mask:
            if self._without_data < _STALE_AFTER_READS:
                self._without_data += 1
                return self._last
            return self._missing(bus)
        if (
            max(counts) >= table.max_count
            or min(counts) < -table.max_count
            or (status == 0xFF and self._data.raw == self._floating)
        ):
            return self._missing(bus)
        self._without_data = 0
        self._last = counts[self._axis] * self._m_s2_per_count
        return self._last

    def close(self) -> None:
        """Release the bus; may be called twice."""
        if self._bus is not None:
            self._bus.close()
            self._bus = None

    @property
    def _place(self) -> str:
        config = self._config
        return f"accelerometer.bus = {config.bus!r}, accelerometer.address = 0x{config.address:02x}"

    def _missing(self, bus: smbus2.SMBus) -> float:
        self.faults += 1
        self._without_data += 1
        self._last = nan
        if self._without_data % _SET_UP_AGAIN_AFTER_READS == 0:
            try:
                self._set_up(bus)
            except OSError:  # still away; the next turn comes
                return nan
        return nan

    def _check_identity(self, bus: smbus2.SMBus) -> None:
        table = self._table
        identity = bus.read_byte_data(self._config.address, table.identity_register)
        if identity != table.identity:
            raise UserError(
                f"{self._place}: the device says 0x{identity:02x} in register "
                f"0x{table.identity_register:02x}, a {table.name} says 0x{table.identity:02x}; "
                "correct accelerometer.driver or accelerometer.address"
            )

    def _set_up(self, bus: smbus2.SMBus) -> None:
        for register, value in self._table.set_up[self._config.full_scale_g]:
            bus.write_byte_data(self._config.address, register, value)

    def _await_sample(self) -> None:
        for _ in range(round(self._wait_s / _POLL_S)):
            if self.read() == self._last:  # a number: NaN equals nothing
                return
            self._sleep(_POLL_S)
        raise UserError(
            f"{self._place}: the {self._table.name} gives no samples "
            f"{self._wait_s:g} s after its set-up; "
            "switch its power off and on, and check that the simulated rig runs where there is one"
        )
