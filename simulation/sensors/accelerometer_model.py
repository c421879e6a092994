"""The model file's [accelerometer] section, completed by the figures of a certain device."""

from math import hypot, pi, sqrt

import msgspec

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.common.files.model import Accelerometer
from stillarm.drivers.accelerometers.accelerometer_factory import mean_hold_s, open_accelerometer
from stillarm.drivers.accelerometers.register_tables import TABLES
from stillarm.drivers.accelerometers.register_tables.register_table import choose_filter
from stillarm.drivers.accelerometers.serial_devices import SERIAL_DEVICES
from stillarm.drivers.buses.i2c import MEMORY_PREFIX
from stillarm.drivers.buses.serial_port import PTY_PREFIX
from stillarm.drivers.emulation.emulated_accelerometer import emulated_driver

_FIRST_ORDER = pi / 2.0  # noise bandwidth of a first-order lag over its 3 dB bandwidth


def presented_by(device: AccelerometerDevice, name: str) -> AccelerometerDevice:
    """The configured accelerometer, mounted as it is, as the emulated driver `name`. Raises UserError for none such."""
    return msgspec.structs.replace(
        device,
        driver=emulated_driver(name),
        bus=device.bus if device.bus.startswith(MEMORY_PREFIX) else f"{MEMORY_PREFIX}rig-i2c",
        port=device.port if device.port.startswith(PTY_PREFIX) else f"{PTY_PREFIX}rig-accelerometer",
    )


def with_device(accelerometer: Accelerometer, device: AccelerometerDevice) -> Accelerometer:
    """The accelerometer as this device makes it: its delay, its range where that is less, its noise added to the arm's.

    Scale and bias stay: they are the mounting's and the specimen's. Raises UserError for settings it does not have.
    """
    driver = open_accelerometer(device, wait_s=0.0)
    if driver is None:
        return accelerometer
    return msgspec.structs.replace(
        accelerometer,
        delay_s=driver.delay_s,
        range_m_s2=min(accelerometer.range_m_s2, driver.range_m_s2),
        noise_std_m_s2=hypot(accelerometer.noise_std_m_s2, device_noise_std_m_s2(device)),
    )


def as_read(accelerometer: Accelerometer, device: AccelerometerDevice, cycle_s: float) -> Accelerometer:
    """The same with the delay that the loop sees: a sample of a slower device stands until the next one comes."""
    driver = open_accelerometer(device, wait_s=0.0)
    hold_s = 0.0 if driver is None else mean_hold_s(driver, cycle_s)
    return msgspec.structs.replace(accelerometer, delay_s=accelerometer.delay_s + hold_s)


def device_noise_std_m_s2(device: AccelerometerDevice) -> float:
    """The device's own noise in one sample, m/s^2: its density over its filter's noise bandwidth."""
    if device.driver in TABLES:
        table = TABLES[device.driver]
        bandwidth_hz = choose_filter(table, device).bandwidth_hz
        return table.noise_m_s2_per_sqrt_hz * sqrt(_FIRST_ORDER * bandwidth_hz)
    if device.driver in SERIAL_DEVICES:
        return SERIAL_DEVICES[device.driver].noise_std_m_s2
    return 0.0
