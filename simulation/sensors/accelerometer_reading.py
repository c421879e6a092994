"""What the configured accelerometer's driver gives for an acceleration, without a bus in between.

Virtual time takes this short cut; that it gives the same numbers as driver, bus and emulator together is tested.
"""

import struct
from collections.abc import Callable
from math import nan

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.drivers.accelerometers.mounting import measured_direction, sensed_axes
from stillarm.drivers.accelerometers.register_tables import TABLES
from stillarm.drivers.accelerometers.register_tables.register_table import choose_filter, choose_full_scale
from stillarm.drivers.accelerometers.serial_devices import SERIAL_DEVICES
from stillarm.drivers.standard_gravity import STANDARD_GRAVITY_M_S2

_SINGLE = struct.Struct("<f")

Quantise = Callable[[float], float]


def accelerometer_reading(device: AccelerometerDevice, cycle_s: float = 0.001) -> Callable[[float], float]:
    """From the acceleration that the sensor feels, m/s^2, to what its driver reads, m/s^2, once a cycle.

    Quantised and clipped; a device slower than the loop repeats its last sample. Raises UserError for settings that
    the device does not have, and for one that only real hardware has.
    """
    if device.driver in ("none", "iio"):
        return lambda acceleration_m_s2: nan
    rate_hz, quantise = _device(device)
    weights = measured_direction(device)
    along = [(axis, weight) for axis, weight in enumerate(weights) if weight != 0.0]
    held, phase = nan, 0.0

    def read(acceleration_m_s2: float) -> float:
        nonlocal held, phase
        phase += min(1.0, rate_hz * cycle_s)
        if phase < 1.0 - 1e-9:
            return held
        phase -= 1.0
        sensed = sensed_axes(acceleration_m_s2, device)
        held = sum(quantise(sensed[axis]) * weight for axis, weight in along) - device.bias_m_s2
        return held

    return read


def _device(device: AccelerometerDevice) -> tuple[float, Quantise]:
    """(samples a second, what becomes of one axis)."""
    if device.driver in TABLES:
        table = TABLES[device.driver]
        full_scale, chosen = choose_full_scale(table, device), choose_filter(table, device)
        step = chosen.count_step
        per_m_s2 = full_scale.counts_per_g / step / STANDARD_GRAVITY_M_S2
        limit = full_scale.max_count // step
        m_s2_per_count = STANDARD_GRAVITY_M_S2 / full_scale.counts_per_g

        def counted(a: float) -> float:
            return min(max(round(a * per_m_s2), -limit), limit - 1) * step * m_s2_per_count

        return chosen.rate_hz, counted
    serial = SERIAL_DEVICES[device.driver]
    step_m_s2 = serial.resolution_m_s2
    if not step_m_s2:
        return serial.rate_hz, lambda a: float(_SINGLE.unpack(_SINGLE.pack(a))[0])
    highest = round(serial.range_m_s2 / step_m_s2)
    return serial.rate_hz, lambda a: min(max(round(a / step_m_s2), -highest), highest - 1) * step_m_s2
