"""What the configured accelerometer's driver gives for an acceleration, without a bus in between.

Virtual time takes this short cut; that it gives the same numbers as driver, smbus2 and emulator together is tested.
"""

from collections.abc import Callable
from math import nan

from common.configuration import AccelerometerDevice
from drivers.accelerometer import STANDARD_GRAVITY_M_S2
from drivers.lis3lv02dq import LIS3LV02DQ


def accelerometer_reading(device: AccelerometerDevice) -> Callable[[float], float]:
    """From the acceleration that the sensor feels, m/s^2, to what its driver reads, m/s^2: quantised and clipped."""
    if device.driver == "none":
        return lambda acceleration_m_s2: nan
    counts_per_g = LIS3LV02DQ.counts_per_g[device.full_scale_g]
    counts_per_m_s2 = counts_per_g / STANDARD_GRAVITY_M_S2
    m_s2_per_count = STANDARD_GRAVITY_M_S2 / counts_per_g
    lowest, highest = -LIS3LV02DQ.max_count, LIS3LV02DQ.max_count - 1

    def read(acceleration_m_s2: float) -> float:
        counts = round(acceleration_m_s2 * counts_per_m_s2)
        return min(max(counts, lowest), highest) * m_s2_per_count

    return read
