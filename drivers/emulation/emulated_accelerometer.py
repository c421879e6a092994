"""Makes the emulated accelerometer of the configuration, for the simulated rig."""

from typing import Protocol, cast, get_args

from stillarm.common.files.configuration import AccelerometerDevice, AccelerometerDriver
from stillarm.common.user_error import UserError
from stillarm.drivers.accelerometers.serial_devices import SERIAL_DEVICES
from stillarm.drivers.buses.i2c import MEMORY_PREFIX
from stillarm.drivers.buses.parts import SENSED_PARTS
from stillarm.drivers.buses.serial_port import PTY_PREFIX
from stillarm.drivers.emulated_chips.shared_registers import Failure, SensedRegisters
from stillarm.drivers.emulation.serial_accelerometer_device import EmulatedSerialAccelerometer

EMULATED = (*SENSED_PARTS, *SERIAL_DEVICES)


class EmulatedAccelerometer(Protocol):
    """An emulated sensor: it receives accelerations and presents them to the driver."""

    def publish(self, acceleration_xyz_m_s2: tuple[float, float, float]) -> None:
        """Set the acceleration, m/s^2 along the sensor's axes; once a period."""

    def inject(self, failure: Failure) -> None:
        """Make the device fail from now on; Failure.NONE repairs it."""

    def close(self) -> None:
        """Remove the device; may be called twice."""


class NoAccelerometer:
    """For a configuration without an accelerometer."""

    def publish(self, acceleration_xyz_m_s2: tuple[float, float, float]) -> None:
        """Ignore the acceleration."""

    def inject(self, failure: Failure) -> None:
        """Do nothing: nothing can fail."""

    def close(self) -> None:
        """Do nothing: there is nothing to remove."""


def emulated_driver(name: str) -> AccelerometerDriver:
    """The driver of that name, if there is an emulator for it. Raises UserError."""
    for driver in get_args(AccelerometerDriver):
        if driver == name and name in (*EMULATED, "none"):
            return cast(AccelerometerDriver, driver)
    raise UserError(f"accelerometer {name!r}: no emulator for it; use {', '.join(EMULATED)} or none")


def emulate_accelerometer(device: AccelerometerDevice, period_s: float) -> EmulatedAccelerometer:
    """Make the emulated accelerometer. period_s: time from one publish() to the next.

    Raises UserError for a real bus or port, and for a device without an emulator.
    """
    if device.driver == "none":
        return NoAccelerometer()
    if device.driver in SERIAL_DEVICES:
        if not device.port.startswith(PTY_PREFIX):
            raise UserError(
                f"accelerometer.port = {device.port!r}: the simulated rig needs an emulated port, such as 'pty:rig'"
            )
        return EmulatedSerialAccelerometer(device.driver, device.port, period_s)
    if device.driver not in SENSED_PARTS:
        raise UserError(
            f"accelerometer.driver = {device.driver!r}: the simulated rig cannot stand in for it; "
            f"use {', '.join(SENSED_PARTS)} or {', '.join(SERIAL_DEVICES)}"
        )
    if not device.bus.startswith(MEMORY_PREFIX):
        raise UserError(
            f"accelerometer.bus = {device.bus!r}: the simulated rig needs a bus in memory, such as 'memory:rig-i2c'"
        )
    return SensedRegisters(device.bus.removeprefix(MEMORY_PREFIX), SENSED_PARTS[device.driver], period_s)
