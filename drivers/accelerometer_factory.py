"""The accelerometer that the configuration names."""

from common.configuration import AccelerometerDevice
from drivers.accelerometer import Accelerometer

_ENOUGH = 0.99  # of the loop's rate: a device's clock may be off by as much


def open_accelerometer(config: AccelerometerDevice, *, wait_s: float = 10.0) -> Accelerometer | None:
    """The configured accelerometer, not yet started; None for "none". Raises UserError for settings it does not have.

    wait_s: how long start() may wait for an emulator to appear, and for a sample; 0 where nothing moves meanwhile.
    """
    if config.driver == "none":
        return None
    # Each imports what it needs only where it is named: the daemons start sooner.
    if config.driver == "iio":
        from drivers.iio_accelerometer import IioAccelerometer

        return IioAccelerometer(config, wait_s=wait_s)
    if config.driver in ("witmotion", "xsens", "vectornav", "microcontroller"):
        from drivers.serial_accelerometer import SerialAccelerometer
        from drivers.serial_devices import SERIAL_DEVICES

        return SerialAccelerometer(config, SERIAL_DEVICES[config.driver], wait_s=wait_s)
    from drivers.accelerometer_tables import TABLES
    from drivers.i2c_accelerometer import I2cAccelerometer

    return I2cAccelerometer(config, TABLES[config.driver], wait_s=wait_s)


def held_samples_statement(accelerometer: Accelerometer, cycle_s: float) -> str | None:
    """One line for a device that is slower than the loop: what that costs; None for one that is not."""
    rate_hz = accelerometer.rate_hz
    if not rate_hz < _ENOUGH / cycle_s:
        return None
    return (
        f"accelerometer: {rate_hz:g} samples a second for {1.0 / cycle_s:g} cycles: a sample stands for up to "
        f"{1e3 / rate_hz:.1f} ms, {1e3 * mean_hold_s(accelerometer, cycle_s):.1f} ms on average"
    )


def mean_hold_s(accelerometer: Accelerometer, cycle_s: float) -> float:
    """How much older than necessary a sample is on average because it stands until the next one comes, s."""
    rate_hz = accelerometer.rate_hz
    return max(0.0, 0.5 * (1.0 / rate_hz - cycle_s)) if rate_hz > 0.0 else 0.0
