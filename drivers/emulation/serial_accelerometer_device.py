"""An emulated serial accelerometer, at the device's end of a pseudo terminal."""

from stillarm.drivers.emulated_chips.shared_registers import Failure
from stillarm.drivers.emulation.pty_port import PtyPort
from stillarm.drivers.emulation.serial_senders import SENDERS, SerialSender

_KEY = "accelerometer.port"
_LATE_SAMPLES = 20
_GARBAGE_BYTES = 24


class EmulatedSerialAccelerometer:
    """Sends published accelerations as frames.

    Failures: STUCK: silence. GARBAGE: other bytes. LATE: twenty samples at a time. WRONG_IDENTITY: text instead of
    frames. UNPLUGGED: the port is gone, and the settings are lost.
    """

    def __init__(self, name: str, port: str, period_s: float = 0.001) -> None:
        """name: of stillarm.drivers.accelerometers.serial_devices; port: "pty:NAME". period_s: time from one
        publish() to the next."""
        self._name = name
        self._port_name = port
        self._port: PtyPort | None = PtyPort(port, _KEY)
        self._sender: SerialSender = SENDERS[name]()
        self._period_s = period_s
        self._published = 0
        self._phase = 0.0
        self._failure = Failure.NONE
        self._held: list[bytes] = []
        self._noise = 1

    def publish(self, acceleration_xyz_m_s2: tuple[float, float, float]) -> None:
        """Set the acceleration, and send it when the configured rate is due."""
        self._published += 1
        port, sender = self._port, self._sender
        if port is None:
            return
        command = port.read()
        if command and self._failure not in (Failure.STUCK, Failure.WRONG_IDENTITY):
            port.write(sender.obey(command))
        self._phase += min(1.0, sender.rate_hz * self._period_s)
        if self._phase < 1.0 - 1e-9:
            return
        self._phase -= 1.0
        self._send(port, sender.frames(acceleration_xyz_m_s2, self._published * self._period_s))

    def inject(self, failure: Failure) -> None:
        """Make the device fail from now on; Failure.NONE repairs it."""
        if failure == Failure.UNPLUGGED:
            if self._port is not None:
                self._port.close()
            self._port = None
            self._sender = SENDERS[self._name]()
        elif self._port is None:
            self._port = PtyPort(self._port_name, _KEY)
        self._failure = failure

    def close(self) -> None:
        """Remove the port; may be called twice."""
        if self._port is not None:
            self._port.close()
        self._port = None

    def _send(self, port: PtyPort, frames: bytes) -> None:
        failure = self._failure
        if failure in (Failure.STUCK, Failure.NAK):
            return
        if failure == Failure.GARBAGE:
            frames = bytes(self._random() for _ in range(_GARBAGE_BYTES))
        elif failure == Failure.WRONG_IDENTITY:
            frames = b"$GPGGA,,,,,,0,,,,,,,,*66\r\n"
        if failure == Failure.LATE:
            self._held.append(frames)
            if len(self._held) < _LATE_SAMPLES:
                return
        if self._held:
            frames = b"".join([*self._held, frames])
            self._held.clear()
        port.write(frames)

    def _random(self) -> int:
        self._noise = (self._noise * 1664525 + 1013904223) & 0xFFFFFFFF
        return self._noise >> 24
