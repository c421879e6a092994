"""The rig's end of the line drive: this class goes into simulation/rig/rig_drive.py."""

from stillarm.drivers.emulation.line_motor import LineMotor

from stillarm.common.files.configuration import DriveDevice
from stillarm.drivers.emulation.pty_port import PtyPort


class RigLine:
    """A line drive on a pseudo terminal."""

    def __init__(self, config: DriveDevice) -> None:
        """Raises UserError for a port that is no emulator's."""
        self._gear_ratio, self.motor = config.gear_ratio, LineMotor()
        self._port = PtyPort(config.line.port, "drive.line.port")

    def poll(self, now_s: float) -> float:
        """Take and answer the lines that have arrived."""
        self._port.write(self.motor.receive(self._port.read(), now_s))
        return self.motor.velocity_command(now_s) / self._gear_ratio

    @property
    def commanded(self) -> bool:
        """Whether a velocity was commanded after that of the start."""
        return self.motor.commands > 1

    def report(self, position_rad: float, velocity_rad_s: float) -> None:
        """For the next answer."""
        self.motor.position_rad = position_rad * self._gear_ratio
        self.motor.velocity_rad_s = velocity_rad_s * self._gear_ratio

    def close(self) -> None:
        """Hang up."""
        self._port.close()
