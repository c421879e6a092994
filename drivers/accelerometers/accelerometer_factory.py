"""Opens the accelerometer that the configuration names."""

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.drivers.accelerometers.accelerometer import Accelerometer

_ENOUGH = 0.99  # of the loop's rate: allowed error of a device's clock


def open_accelerometer(config: AccelerometerDevice, *, wait_s: float = 10.0) -> Accelerometer | None:
    """The configured accelerometer, not yet started; None for "none". Raises UserError for settings it does not have.

    wait_s: how long start() may wait for an emulator and for a sample; 0 if nothing advances during start().
    """
    if config.driver == "none":
        return None
    # Only the named driver is imported, so that the daemons start faster.
    if config.driver == "iio":
        from stillarm.drivers.accelerometers.iio_accelerometer import IioAccelerometer

        return IioAccelerometer(config, wait_s=wait_s)
    if config.driver in ("witmotion", "xsens", "vectornav", "microcontroller"):
        from stillarm.drivers.accelerometers.serial_accelerometer import SerialAccelerometer
        from stillarm.drivers.accelerometers.serial_devices import SERIAL_DEVICES

        return SerialAccelerometer(config, SERIAL_DEVICES[config.driver], wait_s=wait_s)
    from stillarm.drivers.accelerometers.i2c_accelerometer import I2cAccelerometer
    from stillarm.drivers.accelerometers.register_tables import TABLES

    return I2cAccelerometer(config, TABLES[config.driver], wait_s=wait_s)


def held_samples_statement(accelerometer: Accelerometer, cycle_s: float) -> str | None:
    """A line about the cost of a device that is slower than the loop; None for a faster one."""
    rate_hz = accelerometer.rate_hz
    if not rate_hz < _ENOUGH / cycle_s:
        return None
    return (
        f"accelerometer: {rate_hz:g} samples a second for {1.0 / cycle_s:g} cycles: each sample is used for up to "
        f"{1e3 / rate_hz:.1f} ms, {1e3 * mean_hold_s(accelerometer, cycle_s):.1f} ms on average"
    )


def mean_hold_s(accelerometer: Accelerometer, cycle_s: float) -> float:
    """Mean additional age of a sample, because it is used until the next one arrives, s."""
    rate_hz = accelerometer.rate_hz
    return max(0.0, 0.5 * (1.0 / rate_hz - cycle_s)) if rate_hz > 0.0 else 0.0
