"""An invented drive on a serial port. `v RAD_S` moves the motor; `POSITION VELOCITY` answers that, and `?`.

It stops by itself 0.1 s after the last `v`. A port that is lost stays lost: the state grows old, which is a fault.
"""

import time
from collections.abc import Callable
from math import inf, isfinite, nan

from stillarm.common.files.configuration import DriveDevice
from stillarm.drivers.buses.serial_port import PortLost, SerialPort
from stillarm.drivers.drives.drive import DriveProbe, JointState


class LineDrive:
    """Implements stillarm.drivers.drives.drive.Drive."""

    def __init__(self, config: DriveDevice, *, clock: Callable[[], float] = time.monotonic) -> None:
        """Opens nothing."""
        self._name, self._gear_ratio, self._clock = config.line.port, config.gear_ratio, clock
        self._port: SerialPort | None = None
        self._rest = b""
        self._state, self._heard_s, self._reports = (nan, nan), -inf, 0

    def start(self) -> None:
        """Open the port and hold still. Raises UserError."""
        self._port = SerialPort(self._name, 115200, "drive.line.port")
        self.command(0.0)

    def command(self, velocity_rad_s: float) -> None:
        """Send the joint velocity command; zero for one that is not finite."""
        motor_rad_s = velocity_rad_s * self._gear_ratio if isfinite(velocity_rad_s) else 0.0
        self._write(b"v %.6f\n" % motor_rad_s)

    def state(self) -> JointState:
        """The newest report; never blocks."""
        try:
            *lines, self._rest = (self._rest + (self._port.read() if self._port else b"")).split(b"\n")
        except PortLost:
            lines, self._port = [], None
        for line in lines:
            try:
                position, velocity = (float(word) / self._gear_ratio for word in line.split())
            except ValueError:
                continue  # garbage
            if isfinite(position) and isfinite(velocity):
                self._state, self._heard_s = (position, velocity), self._clock()
                self._reports += 1
        return JointState(*self._state, self._clock() - self._heard_s)

    def probe(self, span_s: float) -> DriveProbe:
        """Ask for reports, command nothing. Raises UserError."""
        self._port = SerialPort(self._name, 115200, "drive.line.port")
        until = self._clock() + span_s
        while self._clock() < until:
            self._write(b"?\n")
            time.sleep(0.002)
            self.state()
        return DriveProbe(f"line drive at {self._name}", self._reports, span_s, self._state[0])

    def close(self) -> None:
        """Command zero and release the port; may be called twice."""
        self.command(0.0)
        if self._port is not None:
            self._port.close()
            self._port = None

    def _write(self, data: bytes) -> None:
        try:
            if self._port is not None:
                self._port.write(data)
        except PortLost:
            self._port = None
