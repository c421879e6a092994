"""An ODrive over its ASCII protocol on a serial port (docs.odriverobotics.com; firmware's ascii_protocol.cpp).

A cycle writes `v AXIS turn/s` and `f AXIS`, at intervals also `u AXIS`, which feeds the drive's watchdog (some firmware
does not accept `v` as a sign of life) and reads its state. Available lines are read without waiting: a report has two
numbers, the answer to a read has one.
"""

import os
import time
from collections.abc import Callable
from math import inf, isfinite, nan, pi

from stillarm.common.files.configuration import DriveDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.buses.serial_port import PortLost, SerialPort, port_path
from stillarm.drivers.drives.drive import DriveProbe, JointState
from stillarm.drivers.drives.odrive_lines import LineReader, checked_line

WATCHDOG_S = 0.1
_LEAST_BAUD = 460_800  # for the 30 bytes out and 30 back of each 1 ms cycle: docs/hardware.md
CLOSED_LOOP = 8  # axis state
_IDLE = 1
_VELOCITY_CONTROL, _PASSTHROUGH = 2, 1
_HOUSEKEEPING_EVERY = 10  # commands: far more often than the watchdog requires
_ANSWER_S = 1.0
_ARM_S = 2.0
_RETRY_S = 0.5
_ARM_AGAIN_S = 0.2
_POLL_S = 0.002


class OdriveDrive:
    """Commands a joint's velocity and receives its state; implements stillarm.drivers.drives.drive.Drive.

    If the port disappears, it is reopened as soon as it is back. An axis that has left closed-loop control (watchdog,
    error) is cleared and armed again, but only while the command is zero.
    """

    def __init__(
        self,
        config: DriveDevice,
        *,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Opens nothing."""
        self._config = config.odrive
        self._turns_per_rad = config.gear_ratio / (2.0 * pi)
        self._clock, self._sleep = clock, sleep
        self._axis = config.odrive.axis
        self._port: SerialPort | None = None
        self._lines = LineReader()
        self._away_since_s = self._armed_s = -inf
        self._commands = 0
        self._axis_state = 0
        self._position = self._velocity = nan
        self._good_s = -inf
        self._heard: list[str] = []
        self._running = False
        self.reports = 0
        self.refused = 0
        """Commands that were not finite; zero was sent instead."""
        self.reopened = 0

    @property
    def corrupt_lines(self) -> int:
        """Number of lines that were ignored for their checksum."""
        return self._lines.corrupt

    def start(self) -> None:
        """Open the port, check that an ODrive answers, arm it at zero velocity. Raises UserError with a remedy."""
        self._connect()
        self._running = True
        try:
            self._arm()
            self._await(lambda: self._axis_state == CLOSED_LOOP, _ARM_S, "r axis{}.current_state")
        except UserError:
            self.close()
            raise
        if self._axis_state != CLOSED_LOOP:
            state = self._axis_state
            self.close()
            raise UserError(
                f"{self._place}: axis {self._axis} does not enter closed-loop control (it stays in state {state}); "
                "`odrivetool` and dump_errors() show why; calibrate motor and encoder first"
            )
        self.state()

    def command(self, velocity_rad_s: float) -> None:
        """Send the joint velocity command. A command that is not finite is counted and sent as zero."""
        if not self._running:
            raise RuntimeError("command() before start()")
        if not isfinite(velocity_rad_s):
            self.refused += 1
            velocity_rad_s = 0.0
        if self._port is None:
            self._reopen()
            return
        axis = self._axis
        out = checked_line(f"v {axis} {velocity_rad_s * self._turns_per_rad:.6f}") + checked_line(f"f {axis}")
        if self._commands % _HOUSEKEEPING_EVERY == 0:
            out += checked_line(f"u {axis}") + checked_line(f"r axis{axis}.current_state")
        self._commands += 1
        self._write(out)
        if self._axis_state not in (0, CLOSED_LOOP) and velocity_rad_s == 0.0:
            self._arm_again()

    def state(self) -> JointState:
        """The newest report; never blocks. Before the first one: NaN, NaN and an infinite age."""
        if not self._running:
            raise RuntimeError("state() before start()")
        self._read()
        return JointState(self._position, self._velocity, self._clock() - self._good_s)

    def probe(self, span_s: float) -> DriveProbe:
        """Ask for identity and reports without arming or commanding. Raises UserError without an answer."""
        self._connect()
        try:
            identity = next((line for line in self._heard if line.startswith("Hardware")), "ODrive")
            before, until = self.reports, self._clock() + span_s
            self._write(checked_line(f"r axis{self._axis}.error"))
            while self._clock() < until:
                self._write(checked_line(f"f {self._axis}"))
                self._sleep(_POLL_S)
                self._read()
            errors = [line for line in self._heard if line.isdigit() and int(line) != 0]
            notes = tuple(
                f"axis {self._axis} reports error {int(error):#x}; `odrivetool` and dump_errors() explain it"
                for error in errors
            )
            return DriveProbe(
                identity, self.reports - before, span_s, self._position, notes + self._too_slow()
            )
        finally:
            self._drop()

    def close(self) -> None:
        """Command zero, disarm, release the port; may be called twice."""
        if self._port is not None and self._running:
            self._write(
                checked_line(f"v {self._axis} 0")
                + checked_line(f"w axis{self._axis}.requested_state {_IDLE}")
            )
        self._running = False
        self._drop()

    def _too_slow(self) -> tuple[str, ...]:
        """A note if the UART is too slow for a cycle's lines; over USB (ttyACM) the rate has no effect."""
        uart = (
            "ttyACM" not in os.path.realpath(port_path(self._config.port)) and "pty" not in self._config.port
        )
        if not uart or self._config.baud >= _LEAST_BAUD:
            return ()
        return (
            f"drive.odrive.baud = {self._config.baud}: an error for a 1 ms cycle, which needs {_LEAST_BAUD}; raise it "
            "here and in the ODrive's config.uart_a_baudrate, or use USB",
        )

    @property
    def _place(self) -> str:
        return f"drive.odrive.port = {self._config.port!r}"

    def _connect(self) -> None:
        self.close()
        self._port = SerialPort(self._config.port, self._config.baud, "drive.odrive.port")
        self._lines = LineReader()
        self._heard = []
        self._write(b"\n")  # ends a line that another program may have begun
        self._await(lambda: any("ersion" in line for line in self._heard), _ANSWER_S, "i")
        if not any("ersion" in line for line in self._heard):
            self._drop()
            raise UserError(
                f"{self._place}: no ODrive answers; check its power and the cable, that ASCII is its protocol on this "
                "port (config.uart_a_baudrate = drive.odrive.baud, enable_ascii_protocol_on_usb), or correct the port"
            )

    def _await(self, condition: Callable[[], bool], within_s: float, ask: str) -> None:
        """Ask and read until the condition holds or the time is over."""
        until = self._clock() + within_s
        asked_s = -inf
        while not condition() and self._clock() < until:
            if self._clock() - asked_s > 0.1:
                asked_s = self._clock()
                self._write(checked_line(ask.format(self._axis)) + checked_line(f"u {self._axis}"))
            self._sleep(_POLL_S)
            self._read()

    def _arm(self) -> None:
        """Clear errors, and enter velocity control at zero, with the drive's watchdog."""
        axis = f"axis{self._axis}"
        for text in (
            "sc",
            f"w {axis}.config.watchdog_timeout {WATCHDOG_S}",
            f"u {self._axis}",
            f"w {axis}.config.enable_watchdog 1",
            f"w {axis}.controller.config.control_mode {_VELOCITY_CONTROL}",
            f"w {axis}.controller.config.input_mode {_PASSTHROUGH}",
            f"v {self._axis} 0",
            f"w {axis}.requested_state {CLOSED_LOOP}",
        ):
            self._write(checked_line(text))

    def _arm_again(self) -> None:
        if self._clock() - self._armed_s > _ARM_AGAIN_S:
            self._armed_s = self._clock()
            self._arm()

    def _reopen(self) -> None:
        if self._clock() - self._away_since_s < _RETRY_S:
            return
        self._away_since_s = self._clock()
        try:
            self._port = SerialPort(self._config.port, self._config.baud, "drive.odrive.port")
        except UserError:
            return  # not back yet
        self._lines = LineReader()
        self._axis_state = _IDLE  # must be assumed
        self.reopened += 1

    def _read(self) -> None:
        if self._port is None:
            return
        try:
            data = self._port.read()
        except PortLost:
            self._lose()
            return
        for text in self._lines.feed(data):
            self._take(text)

    def _take(self, text: str) -> None:
        words = text.split()
        if len(words) == 2:
            try:
                position, velocity = float(words[0]), float(words[1])
            except ValueError:
                pass
            else:
                if isfinite(position) and isfinite(velocity):
                    self._position = position / self._turns_per_rad
                    self._velocity = velocity / self._turns_per_rad
                    self.reports += 1
                    if self._axis_state == CLOSED_LOOP:
                        self._good_s = self._clock()
                return
        if self._running and len(words) == 1 and text.isdigit():
            self._axis_state = int(text)
        elif not self._running:
            self._heard.append(text)

    def _write(self, data: bytes) -> None:
        if self._port is not None:
            try:
                self._port.write(data)
            except PortLost:
                self._lose()

    def _lose(self) -> None:
        self._away_since_s = self._clock()
        self._drop()

    def _drop(self) -> None:
        if self._port is not None:
            self._port.close()
            self._port = None
