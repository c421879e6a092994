"""The driver of every I2C accelerometer: it reads a table of drivers/accelerometers/register_tables.

One transfer with prepared messages reads status and data. If the device disappears, the driver probes for it and sets
it up again with one small transfer a read, and less often if the bus is slow to fail, so that the loop keeps its cycle.
"""

import time
from collections.abc import Callable
from math import nan

import smbus2

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.common.user_error import UserError, reason_of
from stillarm.drivers.accelerometers.accelerometer import Reading, SampleStatus
from stillarm.drivers.accelerometers.i2c_fifo import I2cFifo
from stillarm.drivers.accelerometers.i2c_set_up import (
    SetUp,
    WrongIdentity,
    read_registers,
)
from stillarm.drivers.accelerometers.i2c_transfer import StatusAndData
from stillarm.drivers.accelerometers.mounting import measured_direction
from stillarm.drivers.accelerometers.register_tables.register_table import (
    RegisterTable,
    choose_address,
    choose_filter,
    choose_full_scale,
)
from stillarm.drivers.buses.i2c import open_bus
from stillarm.drivers.standard_gravity import STANDARD_GRAVITY_M_S2

_STALE_AFTER_READS = 5  # reads without new data, after which the last sample is no longer used
_LOST_AFTER_READS = 50  # reads without new data, after which the device is set up again
_LOOK_AGAIN_S = 0.010
_LATE_S = 0.002  # two cycles: longer than any healthy transfer
_LATE_IN_A_ROW = 3  # late transfers before the bus is left alone
_LATE_SHARE = 0.05  # largest fraction of the time for late transfers
_POLL_S = 0.001
_NO_NUMBERS = (nan, nan, nan)


class I2cAccelerometer:
    """One axis of the accelerometer; implements stillarm.drivers.accelerometers.accelerometer.Accelerometer
    and BlockAccelerometer."""

    def __init__(
        self,
        config: AccelerometerDevice,
        table: RegisterTable,
        *,
        wait_s: float = 10.0,
        sleep: Callable[[float], None] = time.sleep,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Opens nothing. Raises UserError for a range, filter or address that the part does not have.

        wait_s: how long start() waits for an emulated bus, and then for a first sample. With 0 it waits for neither;
        use 0 if nothing advances during start().
        """
        full_scale, chosen = choose_full_scale(table, config), choose_filter(table, config)
        self.delay_s = chosen.delay_s
        self.rate_hz = chosen.rate_hz
        self.range_m_s2 = full_scale.max_count / full_scale.counts_per_g * STANDARD_GRAVITY_M_S2
        self.faults = 0
        self._config = config
        self._table = table
        self._address = choose_address(table, config)
        self._wait_s = wait_s
        self._sleep = sleep
        self._clock = clock
        self._m_s2_per_count = STANDARD_GRAVITY_M_S2 / full_scale.counts_per_g
        self._weights = [weight * self._m_s2_per_count for weight in measured_direction(config)]
        self._max_count = full_scale.max_count
        self._count_step = chosen.count_step
        self._bus: smbus2.SMBus | None = None
        self._set_up = SetUp(table, self._address, full_scale, chosen)
        self._transfer = StatusAndData(table, self._address)
        self._floating = b"\xff" * table.data_length
        self._last = nan
        self._counts = (0, 0, 0)
        self._status = SampleStatus.SETTING_UP
        self._device_status = -1
        self._read_s = nan
        self._without_data = 0
        self._lost = False
        self._late_in_a_row = 0
        self._not_before_s = 0.0

    def start(self) -> None:
        """Open the bus, check the identity, set rate and range, wait for samples.

        Raises UserError with a remedy for a bus that cannot be opened, a device that does not answer, another device,
        or a device without samples.
        """
        self.close()
        self._bus = open_bus(self._config.bus, wait_s=self._wait_s)
        self._last, self._without_data, self._lost, self._not_before_s = nan, 0, False, 0.0
        try:
            self._set_up_now(self._bus)
            if self._wait_s > 0.0:
                self._await_sample()
        except OSError as error:
            self.close()
            raise UserError(
                f"{self._place}: no {self._table.name} answers ({reason_of(error)}); "
                "check power and wiring, or correct accelerometer.address "
                "(`i2cdetect -y N` lists what answers on bus N)"
            ) from None
        except WrongIdentity as wrong:
            self.close()
            raise UserError(
                f"{self._place}: the device returns 0x{wrong.found.hex()} in register "
                f"0x{self._table.identity_register:02x}, a {self._table.name} returns 0x{self._table.identity.hex()}; "
                "correct accelerometer.driver or accelerometer.address"
            ) from None
        except UserError:
            self.close()
            raise
        self.faults = 0

    def identify(self) -> str:
        """The part and its identity, read now. Raises RuntimeError before start(), OSError without an answer."""
        table = self._table
        identity = read_registers(
            self._opened(), self._address, table.identity_register | table.auto_increment, len(table.identity)
        )
        kind = table.name if identity == table.identity else f"not a {table.name}"
        return f"{kind} at 0x{self._address:02x} on {self._config.bus}, identity 0x{identity.hex()}"

    def read(self) -> float:
        """The newest acceleration along the configured axis, m/s^2; NaN (and counted) if there is none.

        There is none if the bus does not answer, if the bytes cannot be samples, or if no data became ready in more
        than 5 reads; until then the last sample is used. After 50 reads without data the device may have lost its
        power, and is set up again, one transfer a read. Raises RuntimeError before start().
        """
        bus = self._opened()
        now = self._read_s = self._clock()
        if now < self._not_before_s:
            return self._missing(SampleStatus.NO_ANSWER)
        if self._lost:
            return self._look_for_it(bus, now)
        try:
            status, data = self._transfer.read(bus)
        except OSError:
            self._spare_the_loop(now)
            return self._missing(SampleStatus.NO_ANSWER)
        self._spare_the_loop(now)
        return self._take(status, data)

    def last_reading(self) -> Reading:
        """The details of the last read()."""
        scale = self._m_s2_per_count
        x, y, z = self._counts
        there = self._status in (SampleStatus.FRESH, SampleStatus.HELD)
        xyz = (x * scale, y * scale, z * scale) if there else _NO_NUMBERS
        return Reading(xyz, self._status, self._device_status, self._read_s, nan)

    @property
    def bytes_on_bus(self) -> int:
        """Bytes that a read takes on the bus, with the address byte of each message."""
        return self._transfer.bytes_on_bus

    def start_blocks(self) -> None:
        """Switch the FIFO on. Raises UserError if the part has none, OSError if the bus fails."""
        self._fifo().start()

    def read_block(self) -> list[tuple[float, float, float]]:
        """The samples since the last call, oldest first, m/s^2 along the sensor's axes. Raises OSError."""
        scale = self._m_s2_per_count
        return [(x * scale, y * scale, z * scale) for x, y, z in self._fifo().read()]

    def stop_blocks(self) -> None:
        """Switch the FIFO off again. Raises OSError."""
        self._fifo().stop()

    def close(self) -> None:
        """Release the bus; may be called twice."""
        if self._bus is not None:
            self._bus.close()
            self._bus = None

    @property
    def _place(self) -> str:
        return f"accelerometer.bus = {self._config.bus!r}, accelerometer.address = 0x{self._address:02x}"

    def _opened(self) -> smbus2.SMBus:
        if self._bus is None:
            raise RuntimeError("read() before start()")
        return self._bus

    def _fifo(self) -> I2cFifo:
        return I2cFifo(self._opened(), self._address, self._table, self._sleep)

    def _take(self, status: int, data: bytes) -> float:
        self._device_status = status
        if not status & self._table.ready_mask:
            if self._without_data < _STALE_AFTER_READS:
                self._without_data += 1
                self._status = SampleStatus.HELD
                return self._last
            return self._missing(SampleStatus.STALE)
        counts = self._table.decode(data)
        if (status == 0xFF and data == self._floating) or not self._plausible(counts):
            return self._missing(SampleStatus.IMPLAUSIBLE)
        self._without_data = 0
        self._counts = counts
        self._status = SampleStatus.FRESH
        x, y, z = self._weights
        self._last = x * counts[0] + y * counts[1] + z * counts[2] - self._config.bias_m_s2
        return self._last

    def _missing(self, status: SampleStatus) -> float:
        self.faults += 1
        self._without_data += 1
        self._status = status
        self._last = nan
        if self._without_data >= _LOST_AFTER_READS and not self._lost:
            self._lost = True
            self._set_up.restart(self._read_s)
        return nan

    def _look_for_it(self, bus: smbus2.SMBus, now: float) -> float:
        """One step of finding the device and setting it up. The read after the last step is an ordinary one."""
        try:
            if self._set_up.advance(bus, now):
                self._lost, self._without_data = False, 0
        except (OSError, WrongIdentity):
            self._set_up.restart(now, _LOOK_AGAIN_S)
        self._spare_the_loop(now)
        return self._missing(SampleStatus.SETTING_UP)

    def _spare_the_loop(self, started_s: float) -> None:
        """After several transfers that took too long, leave the bus alone for a while. A single one may be our own."""
        took = self._clock() - started_s
        self._late_in_a_row = self._late_in_a_row + 1 if took > _LATE_S else 0
        if self._late_in_a_row >= _LATE_IN_A_ROW:
            self._not_before_s = started_s + took / _LATE_SHARE

    def _plausible(self, counts: tuple[int, int, int]) -> bool:
        limit, step = self._max_count, self._count_step
        return (
            -limit <= min(counts)
            and max(counts) < limit
            and (step == 1 or not (counts[0] | counts[1] | counts[2]) & step - 1)
        )

    def _set_up_now(self, bus: smbus2.SMBus) -> None:
        now = self._clock()
        self._set_up.restart(now)
        while not self._set_up.advance(bus, now):
            if self._set_up.waits_s > now:
                self._sleep(self._set_up.waits_s - now)
                now = max(self._set_up.waits_s, self._clock())

    def _await_sample(self) -> None:
        for _ in range(round(self._wait_s / _POLL_S)):
            if self.read() == self._last:  # True for a number only: NaN differs from itself
                return
            self._sleep(_POLL_S)
        raise UserError(
            f"{self._place}: the {self._table.name} gives no samples "
            f"{self._wait_s:g} s after its set-up; "
            "switch its power off and on; with a simulated rig, check that it runs"
        )
