"""A motor amplifier behind a Microchip MCP4725, a 12-bit DAC on I2C: voltage for velocity (datasheet DS22039D).

There is no feedback: theta comes from the drive model, and the state has no position. Its age is the time since the DAC
last acknowledged a command. The DAC holds its voltage forever and has no dead-man timer. The amplifier's enable input
therefore needs its own, such as a retriggerable monostable on the bus's clock line (docs/hardware.md).
"""

import time
from collections.abc import Callable
from math import inf, isfinite, nan, pi

import smbus2

from stillarm.common.files.configuration import DriveDevice
from stillarm.common.user_error import UserError, reason_of
from stillarm.drivers.buses.i2c import open_bus
from stillarm.drivers.drives.drive import DriveProbe, JointState

_CODES = 4096
_ANSWER_BYTES = 5
_POWER_DOWN = 0x06
_LARGEST_ZERO_ERROR = 8  # codes: negligible against the model's limits
_RETRY_S = 0.002


class Mcp4725Drive:
    """Commands a joint's velocity as a voltage; implements stillarm.drivers.drives.drive.Drive."""

    def __init__(
        self,
        config: DriveDevice,
        *,
        wait_s: float = 10.0,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Opens nothing. wait_s: how long to wait for an emulated bus."""
        self._config = config.mcp4725
        self._codes_per_v = _CODES / self._config.supply_v
        turns_s_per_rad_s = config.gear_ratio / (2.0 * pi)
        per_volt = self._config.turns_s_per_v
        self._v_per_rad_s = turns_s_per_rad_s / per_volt if per_volt else 0.0
        self._wait_s = wait_s
        self._clock, self._sleep = clock, sleep
        self._bus: smbus2.SMBus | None = None
        self._message = smbus2.i2c_msg.write(config.mcp4725.address, [0, 0])
        self._good_s = -inf
        self.faults = 0
        """Commands that the DAC did not acknowledge."""
        self.refused = 0
        """Commands that were not finite; zero was sent instead."""

    @property
    def zero_code(self) -> int:
        """The DAC's code for standstill."""
        return min(max(round(self._config.zero_v * self._codes_per_v), 0), _CODES - 1)

    def code(self, velocity_rad_s: float) -> int:
        """The DAC's code for a joint velocity, clipped to its range."""
        volts = self._config.zero_v + velocity_rad_s * self._v_per_rad_s
        return min(max(round(volts * self._codes_per_v), 0), _CODES - 1)

    def start(self) -> None:
        """Open the bus, command zero and read it back. Raises UserError with a remedy."""
        if self._config.turns_s_per_v == 0.0:
            raise UserError(
                "drive.mcp4725.turns_s_per_v = 0: the motor's speed in turns a second per volt is needed"
            )
        self.close()
        self._bus = open_bus(self._config.bus, wait_s=self._wait_s, key="drive.mcp4725.bus")
        self.command(0.0)
        try:
            code, _ = self._read()
        except UserError:
            self._release()
            raise
        if code != self.zero_code:
            self._release()
            raise UserError(
                f"{self._place}: the device does not keep what is written to it (code {code} instead of "
                f"{self.zero_code}): it is not an MCP4725, or another program writes to it; correct the address"
            )

    def command(self, velocity_rad_s: float) -> None:
        """Set the voltage. A command that is not finite is counted and sent as zero. 3 bytes on the bus."""
        bus = self._bus
        if bus is None:
            raise RuntimeError("command() before start()")
        if not isfinite(velocity_rad_s):
            self.refused += 1
            velocity_rad_s = 0.0
        code = self.code(velocity_rad_s)
        message = self._message
        message.buf[0], message.buf[1] = bytes((code >> 8,)), bytes((code & 0xFF,))
        try:
            bus.i2c_rdwr(message)
        except OSError:
            self.faults += 1
            return
        self._good_s = self._clock()

    def state(self) -> JointState:
        """No position and no velocity; the age of the last acknowledged command."""
        if self._bus is None:
            raise RuntimeError("state() before start()")
        return JointState(nan, nan, self._clock() - self._good_s)

    def probe(self, span_s: float) -> DriveProbe:
        """Read the DAC without writing. Raises UserError if it does not answer."""
        self.close()
        self._bus = open_bus(self._config.bus, wait_s=self._wait_s, key="drive.mcp4725.bus")
        try:
            until, reports = self._clock() + span_s, 0
            code, power_up = self._read()
            while self._clock() < until:
                self._read()
                reports += 1
                self._sleep(_RETRY_S)
        finally:
            self._release()
        notes = ["it has no dead-man timer: give the amplifier's enable input one (docs/hardware.md)"]
        if abs(power_up - self.zero_code) > _LARGEST_ZERO_ERROR:
            notes.append(
                f"its EEPROM holds code {power_up}, which moves the motor at power-up; write code "
                f"{self.zero_code} there, or correct drive.mcp4725.zero_v"
            )
        return DriveProbe(f"DAC at code {code}", reports, span_s, nan, tuple(notes))

    def close(self) -> None:
        """Command zero and release the bus; may be called twice."""
        if self._bus is not None:
            self.command(0.0)
            self._release()

    @property
    def _place(self) -> str:
        return (
            f"drive.mcp4725.bus = {self._config.bus!r}, drive.mcp4725.address = 0x{self._config.address:02x}"
        )

    def _read(self) -> tuple[int, int]:
        """The DAC's present code, and its power-up code in the EEPROM. Raises UserError."""
        answer = smbus2.i2c_msg.read(self._config.address, _ANSWER_BYTES)
        assert self._bus is not None
        try:
            self._bus.i2c_rdwr(answer)
        except OSError as error:
            raise UserError(
                f"{self._place}: no MCP4725 answers ({reason_of(error)}); check power and "
                "wiring, or correct drive.mcp4725.address (`i2cdetect -y N` lists what answers on bus N)"
            ) from None
        status, high, low, eeprom_high, eeprom_low = bytes(answer)
        if status & _POWER_DOWN:
            return -1, (eeprom_high & 0x0F) << 8 | eeprom_low
        return high << 4 | low >> 4, (eeprom_high & 0x0F) << 8 | eeprom_low

    def _release(self) -> None:
        if self._bus is not None:
            self._bus.close()
            self._bus = None
