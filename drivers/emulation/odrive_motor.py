"""An emulated ODrive: answers the lines of its ASCII protocol. Pure: bytes and times in, bytes out.

It implements v, f, u, i, sc, and r and w of the properties below. Its watchdog stops the motor and disarms the axis,
as the firmware's does. Injected failures: `silent` answers nothing, `garbage` corrupts every answer, fail() disarms.
"""

from stillarm.drivers.drives.odrive_lines import LineReader

_IDLE, _CLOSED_LOOP = 1, 8
_WATCHDOG_EXPIRED = 0x800


class OdriveMotor:
    """One axis, its motor's velocity in turns a second."""

    def __init__(self, axis: int = 0) -> None:
        """Idle, as after power-up."""
        self._axis = axis
        self._lines = LineReader()
        self._velocity = 0.0
        self._fed_s: float | None = None
        self._now_s = 0.0
        self.position_turns = 0.0
        self.velocity_turns_s = 0.0
        self.state = _IDLE
        self.error = 0
        self.commands = 0
        self.silent = self.garbage = False
        name = f"axis{axis}"
        self.properties: dict[str, float] = {
            f"{name}.config.watchdog_timeout": 0.0,
            f"{name}.config.enable_watchdog": 0.0,
            f"{name}.controller.config.control_mode": 3.0,
            f"{name}.controller.config.input_mode": 1.0,
        }

    def receive(self, data: bytes, now_s: float) -> bytes:
        """Receive bytes that arrived at `now_s`. Returns the answers."""
        self._now_s = now_s
        self._watch()
        answers = b"".join(map(_answered, filter(None, map(self._obey, self._lines.feed(data)))))
        if self.silent:
            return b""
        return bytes(byte ^ 0x15 for byte in answers) if self.garbage else answers

    def velocity_command(self, now_s: float) -> float:
        """The motor's velocity command at `now_s`, turns a second; zero if the axis is not armed."""
        self._now_s = now_s
        self._watch()
        in_velocity_control = self.properties[f"axis{self._axis}.controller.config.control_mode"] == 2.0
        return self._velocity if self.state == _CLOSED_LOOP and in_velocity_control else 0.0

    def _watch(self) -> None:
        name = f"axis{self._axis}.config"
        enabled = self.properties[f"{name}.enable_watchdog"] == 1.0
        timeout = self.properties[f"{name}.watchdog_timeout"]
        if enabled and timeout > 0.0 and self._fed_s is not None and self._now_s - self._fed_s > timeout:
            self.fail(_WATCHDOG_EXPIRED)

    def fail(self, error: int) -> None:
        """Enter an error: the axis stops and disarms."""
        self.state, self.error, self._velocity = _IDLE, error, 0.0

    def _obey(self, text: str) -> str:
        words = text.split()
        match words:
            case ["v", axis, velocity, *_] if axis == str(self._axis):
                self._velocity = float(velocity)
                self.commands += 1
            case ["f", axis] if axis == str(self._axis):
                return f"{self.position_turns:.6f} {self.velocity_turns_s:.6f}"
            case ["u", axis] if axis == str(self._axis):
                self._fed_s = self._now_s
            case ["sc"]:
                self.error, self._fed_s = 0, self._now_s
            case ["i"]:
                return "Hardware version: 3.6-56V\nFirmware version: 0.5.6\nSerial number: 0"
            case ["r", name]:
                return self._property(name)
            case ["w", name, value]:
                return self._set(name, value)
            case _:
                return "unknown command"
        return ""

    def _property(self, name: str) -> str:
        own = {f"axis{self._axis}.current_state": self.state, f"axis{self._axis}.error": self.error}
        if name in own:
            return str(own[name])
        return f"{self.properties[name]:f}" if name in self.properties else "invalid property"

    def _set(self, name: str, value: str) -> str:
        if name == f"axis{self._axis}.requested_state":
            wanted = int(value)
            self.state = _IDLE if self.error else wanted
            return ""
        if name not in self.properties:
            return "invalid property"
        self.properties[name] = float(value)
        return ""


def _answered(text: str) -> bytes:
    """An answer's lines in the firmware's format: checksum of the text itself, CR LF."""
    out = b""
    for line in text.split("\n"):
        check = 0
        for byte in line.encode("ascii"):
            check ^= byte
        out += f"{line}*{check}\r\n".encode("ascii")
    return out
