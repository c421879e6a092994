"""Opens an I2C bus by its name in the configuration."""

import contextlib
import fcntl

import smbus2

from stillarm.common.user_error import UserError, reason_of

MEMORY_PREFIX = "memory:"
_I2C_TIMEOUT = 0x0702
_TIMEOUT_10_MS = 1  # unit of the kernel's timeout: 10 ms


def open_bus(name: str, *, wait_s: float = 0.0, key: str = "accelerometer.bus") -> smbus2.SMBus:
    """Open /dev/i2c-N, or "memory:NAME": the emulator's registers NAME in memory shared with the simulated rig.

    wait_s: how long to wait for an emulator's registers; a real bus either exists or not. key: the configuration's
    key, for the message. Raises UserError.
    """
    if name.startswith(MEMORY_PREFIX):
        from stillarm.drivers.buses.memory_bus import (
            open_memory_bus,  # no emulator is loaded on real hardware
        )

        try:
            return open_memory_bus(name, wait_s)
        except UserError:
            raise UserError(
                f"{key} = {name!r}: no process offers these registers; start it "
                "(the simulated rig: `stillarm rig`), or name a real bus such as /dev/i2c-1"
            ) from None
    try:
        bus = smbus2.SMBus(name)
        # an adapter without this setting keeps its default, often a second
        with contextlib.suppress(OSError):
            fcntl.ioctl(int(bus.fd or 0), _I2C_TIMEOUT, _TIMEOUT_10_MS)
        return bus
    except FileNotFoundError:
        remedy = "no such bus; load the kernel module i2c-dev (modprobe i2c-dev), or name one of /dev/i2c-*"
    except PermissionError:
        remedy = (
            "permission denied; add this user to the group that owns the bus (usually i2c) and log in again"
        )
    except OSError as error:
        remedy = f"cannot be opened as an I2C bus ({reason_of(error)}); name one of /dev/i2c-*"
    raise UserError(f"{key} = {name!r}: {remedy}")
