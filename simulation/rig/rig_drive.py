"""The simulated rig's drive: an emulator that speaks the configured drive's language.

Each returns the joint velocity that the controller's commands ask for, or the drive's input, and gets the joint's
motion to report. Each has the dead man of its kind; the amplifier behind the DAC drops its enable when the DAC is not
written for 0.1 s.
"""

from math import isfinite, nan, pi
from typing import Any, Protocol

from stillarm.common.datagrams.messages import DriveCommand, DriveInput
from stillarm.common.files.configuration import DriveDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.buses.i2c import MEMORY_PREFIX
from stillarm.drivers.drives.drive_factory import takes_inputs
from stillarm.drivers.drives.drive_gateway import DEAD_MAN_S, DriveGateway
from stillarm.drivers.drives.drive_gateway_socket import DriveGatewaySocket
from stillarm.drivers.emulated_chips.mcp4725_chip import Mcp4725Output
from stillarm.drivers.emulation.cia402_node import Cia402Node
from stillarm.drivers.emulation.odrive_motor import OdriveMotor
from stillarm.drivers.emulation.pty_port import PtyPort

_MAX_MESSAGES = 64
_NOT_A_WIRE = ("virtual", "udp_multicast")
_PAUSE_S = 0.3  # between the setting up of a drive and the first cycle
_CYCLES = 100  # more commands than a set-up sends


class RigDrive(Protocol):
    """The rig's end of the drive."""

    def poll(self, now_s: float) -> float:
        """Take what has arrived; returns the joint velocity to follow at `now_s`, rad/s, or the input; NaN: brake."""

    @property
    def commanded(self) -> bool:
        """Whether a command has come yet."""

    def report(self, position_rad: float, velocity_rad_s: float) -> None:
        """What the joint does, for the drive to report."""

    def close(self) -> None:
        """Release ports and memory; may be called twice."""


def rig_drive(config: DriveDevice, key: bytes, kind: str = "velocity") -> RigDrive:
    """The emulator of the drive that the configuration names. kind: what it obeys, the model's drive.kind.

    Raises UserError where it cannot be.
    """
    if takes_inputs(config, kind):
        return RigGateway(config, key, DriveInput)
    if config.driver == "odrive":
        return RigOdrive(config)
    if config.driver == "cia402":
        return RigCia402(config)
    if config.driver == "mcp4725":
        return RigMcp4725(config)
    return RigGateway(config, key)


class RigGateway:
    """A gateway on a UDP port."""

    def __init__(
        self,
        config: DriveDevice,
        key: bytes,
        takes: type[DriveCommand] | type[DriveInput] = DriveCommand,
    ) -> None:
        """takes: velocities or inputs. Raises UserError when the port is taken."""
        self.gateway = DriveGateway(key, takes=takes)
        self._socket = DriveGatewaySocket(self.gateway, (config.gateway_host, config.gateway_port))

    def poll(self, now_s: float) -> float:
        """Take the datagrams that have arrived."""
        if self.gateway.takes is DriveCommand:
            return self._socket.poll(now_s)
        self._socket.take(now_s)
        value = self.gateway.input_command(now_s)
        return nan if value is None else value

    @property
    def commanded(self) -> bool:
        """Whether a command was accepted yet."""
        return self.gateway.counts.accepted > 0

    def report(self, position_rad: float, velocity_rad_s: float) -> None:
        """Answer the commander."""
        self._socket.report(position_rad, velocity_rad_s)

    def close(self) -> None:
        """Release the port."""
        self._socket.close()


class RigOdrive:
    """An ODrive on a pseudo terminal."""

    def __init__(self, config: DriveDevice) -> None:
        """Raises UserError for a port that is no emulator's."""
        self._turns_per_rad = config.gear_ratio / (2.0 * pi)
        self.motor = OdriveMotor(config.odrive.axis)
        self._port = PtyPort(config.odrive.port, "drive.odrive.port")

    def poll(self, now_s: float) -> float:
        """Take and answer the lines that have arrived."""
        if data := self._port.read():
            self._port.write(self.motor.receive(data, now_s))
        return self.motor.velocity_command(now_s) / self._turns_per_rad

    @property
    def commanded(self) -> bool:
        """Whether a velocity was commanded since the drive was armed."""
        return self.motor.commands > 1  # the first one is that which arms it

    def report(self, position_rad: float, velocity_rad_s: float) -> None:
        """For the next `f`."""
        self.motor.position_turns = position_rad * self._turns_per_rad
        self.motor.velocity_turns_s = velocity_rad_s * self._turns_per_rad

    def close(self) -> None:
        """Hang up."""
        self._port.close()


class RigCia402:
    """A CiA 402 drive on a CAN bus that is no wire."""

    def __init__(self, config: DriveDevice) -> None:
        """Raises UserError for a bus that is a wire, or cannot be opened."""
        if config.cia402.interface not in _NOT_A_WIRE:
            raise UserError(
                f"drive.cia402.interface = {config.cia402.interface!r}: the simulated rig needs a bus that is no wire; "
                "'udp_multicast' (channel '239.74.163.2') between processes"
            )
        from stillarm.drivers.drives.cia402_set_up import can_package

        can = can_package()
        self._message: Any = can.Message
        self._error: type[Exception] = can.CanError
        turns_per_rad = config.gear_ratio / (2.0 * pi)
        self._units_s_per_rad = turns_per_rad * config.cia402.velocity_units_s_per_turn
        self._units_per_rad = turns_per_rad * config.cia402.position_units_per_turn
        self.node = Cia402Node(config.cia402.node)
        self._first_s: float | None = None
        self._set_up_commands = 0
        self._commanded = False
        self._bus = can.Bus(interface=config.cia402.interface, channel=config.cia402.channel)

    def poll(self, now_s: float) -> float:
        """Take and answer the messages that have arrived."""
        for _ in range(_MAX_MESSAGES):
            message = self._bus.recv(0)
            if message is None:
                break
            for identifier, data in self.node.receive(message.arbitration_id, bytes(message.data), now_s):
                self._send(identifier, data)
        if self.node.commands and not self._commanded:
            self._note_command(now_s)
        return self.node.velocity_command(now_s) / self._units_s_per_rad

    @property
    def commanded(self) -> bool:
        """Whether a command came after those that enable the drive."""
        return self._commanded

    def report(self, position_rad: float, velocity_rad_s: float) -> None:
        """For the answer to the next SYNC."""
        self.node.position_units = round(position_rad * self._units_per_rad)
        self.node.velocity_units_s = round(velocity_rad_s * self._units_s_per_rad)

    def close(self) -> None:
        """Leave the bus."""
        self._bus.shutdown()

    def _note_command(self, now_s: float) -> None:
        """The commands of a set-up end with a pause; those of the loop follow."""
        if self._first_s is None:
            self._first_s, self._set_up_commands = now_s, self.node.commands
        elif now_s - self._first_s < _PAUSE_S:
            self._set_up_commands = self.node.commands
        self._commanded = self.node.commands > self._set_up_commands or self.node.commands > _CYCLES

    def _send(self, identifier: int, data: bytes) -> None:
        try:
            self._bus.send(self._message(arbitration_id=identifier, data=data, is_extended_id=False))
        except (self._error, OSError):  # as on a wire: lost
            return


class RigMcp4725:
    """A DAC and the amplifier behind it, which has a dead man of its own."""

    def __init__(self, config: DriveDevice) -> None:
        """Raises UserError for a bus that is no emulator's."""
        dac = config.mcp4725
        if not dac.bus.startswith(MEMORY_PREFIX):
            raise UserError(
                f"drive.mcp4725.bus = {dac.bus!r}: the simulated rig needs a bus in memory, such as 'memory:rig-dac'"
            )
        self._volts_per_code = dac.supply_v / 4096
        self._zero_v = dac.zero_v
        self._rad_s_per_volt = dac.turns_s_per_v * 2.0 * pi / config.gear_ratio
        self.output = Mcp4725Output(
            dac.bus.removeprefix(MEMORY_PREFIX), round(dac.zero_v / self._volts_per_code)
        )
        self._writes = 0
        self._written_s = float("-inf")

    def poll(self, now_s: float) -> float:
        """What the voltage asks for, while the DAC is being written."""
        writes, code = self.output.output()
        if writes != self._writes:
            self._writes, self._written_s = writes, now_s
        if code is None or now_s - self._written_s > DEAD_MAN_S:
            return 0.0
        velocity = (code * self._volts_per_code - self._zero_v) * self._rad_s_per_volt
        # Half a step of the DAC is its zero: the amplifier's offset is trimmed, as on a rig.
        half_step = 0.51 * self._volts_per_code * abs(self._rad_s_per_volt)
        return velocity if isfinite(velocity) and abs(velocity) > half_step else 0.0

    @property
    def commanded(self) -> bool:
        """Whether the DAC was written more often than a start does."""
        return self._writes > 1

    def report(self, position_rad: float, velocity_rad_s: float) -> None:
        """Nobody hears it."""

    def close(self) -> None:
        """Remove the DAC."""
        self.output.close()
