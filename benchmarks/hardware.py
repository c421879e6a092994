"""The cost of reading each accelerometer in the loop, with its emulator; for `stillarm benchmark hardware`.

us_per_read is the median processor time of a read with a fresh sample. It includes the emulator's part: for I2C the
stand-in for kernel and chip, for serial devices the system call on a pseudo terminal. bus_us is the computed time on
the wire of real hardware: 9 bits a byte on I2C at 400 kHz. The loop waits for an I2C transfer, not for a serial one.
"""

import os
import time
from typing import Any

import msgspec
import numpy as np

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.drivers.accelerometers.accelerometer import SampleStatus
from stillarm.drivers.accelerometers.accelerometer_factory import open_accelerometer
from stillarm.drivers.accelerometers.i2c_accelerometer import I2cAccelerometer
from stillarm.drivers.accelerometers.mounting import sensed_axes
from stillarm.drivers.accelerometers.register_tables import TABLES
from stillarm.drivers.accelerometers.serial_devices import SERIAL_DEVICES
from stillarm.drivers.emulation.emulated_accelerometer import emulate_accelerometer, emulated_driver

_READS = 2000  # a trial
_CYCLE_S = 0.001
_FAST_MODE_HZ = 400_000.0
_BITS_PER_BYTE = 9
_HAND_OVER_S = 50e-6  # delivery time of a pseudo terminal


def run(trials: int, seed: int) -> dict[str, Any]:
    """Rows of device, driver, rate_hz, delay_ms, us_per_read, us_per_read_p99, bus_us. The seed has no effect."""
    rows = [_row(name, trials * _READS) for name in (*TABLES, *SERIAL_DEVICES)]
    return {"rows": rows, "seed": seed}


def _row(name: str, reads: int) -> dict[str, Any]:
    place = f"benchmark-{os.getpid()}"
    device = msgspec.structs.replace(
        AccelerometerDevice(driver=emulated_driver(name)), bus=f"memory:{place}", port=f"pty:{place}"
    )
    emulated = emulate_accelerometer(device, _CYCLE_S)
    driver = open_accelerometer(device, wait_s=0.0)
    assert driver is not None
    felt = sensed_axes(1.0, device)
    try:
        driver.start()
        costs: list[float] = []
        while len(costs) < reads:
            emulated.publish(felt)
            if name in SERIAL_DEVICES:
                time.sleep(_HAND_OVER_S)
            started = time.thread_time_ns()
            driver.read()
            cost = time.thread_time_ns() - started
            if driver.last_reading().status == SampleStatus.FRESH:
                costs.append(cost * 1e-3)
    finally:
        driver.close()
        emulated.close()
    table = TABLES.get(name)
    return {
        "device": SERIAL_DEVICES[name].name if table is None else table.name,
        "driver": name,
        "rate_hz": driver.rate_hz,
        "delay_ms": 1e3 * driver.delay_s,
        "us_per_read": float(np.median(costs)),
        "us_per_read_p99": float(np.percentile(costs, 99)),
        "bus_us": 1e6 * _BITS_PER_BYTE * driver.bytes_on_bus / _FAST_MODE_HZ
        if isinstance(driver, I2cAccelerometer)
        else None,
    }
