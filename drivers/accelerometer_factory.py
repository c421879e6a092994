"""The accelerometer that the configuration names."""

from common.configuration import AccelerometerDevice
from drivers.accelerometer import Accelerometer
from drivers.lis3lv02dq import Lis3lv02dq


def open_accelerometer(config: AccelerometerDevice, *, wait_s: float = 10.0) -> Accelerometer | None:
    """The configured accelerometer, not yet started; None for "none".

    wait_s: how long start() may wait for an emulated bus to appear; 0 in virtual time, where nothing moves
    meanwhile.
    """
    return None if config.driver == "none" else Lis3lv02dq(config, wait_s=wait_s)
