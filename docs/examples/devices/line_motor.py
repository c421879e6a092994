"""The emulated line drive. Pure: bytes and times in, bytes out."""


class LineMotor:
    """position_rad, velocity_rad_s: of the motor, as reported. commands: number of `v` lines."""

    def __init__(self) -> None:
        """At rest."""
        self.position_rad = self.velocity_rad_s = self._wanted_rad_s = 0.0
        self._wanted_s, self._rest, self.commands = float("-inf"), b"", 0

    def receive(self, data: bytes, now_s: float) -> bytes:
        """The answers to what arrives at now_s."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            if line.startswith(b"v "):
                self._wanted_rad_s, self._wanted_s = float(line[2:]), now_s
                self.commands += 1
        return b"%.6f %.6f\n" % (self.position_rad, self.velocity_rad_s) if lines else b""

    def velocity_command(self, now_s: float) -> float:
        """The motor's velocity, rad/s; zero 0.1 s after the last command."""
        return self._wanted_rad_s if now_s - self._wanted_s <= 0.1 else 0.0
