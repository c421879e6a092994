"""Buses named "memory:NAME" for smbus2: smbus2's own code runs, with its open, close and ioctl replaced.

smbus2 calls os.open, os.close and fcntl.ioctl through names in its module. When the first emulated bus is requested,
those names are bound to the functions here. Descriptors of other files pass through.
"""

import fcntl
import os
from types import SimpleNamespace
from typing import Any

import smbus2.smbus2

from stillarm.drivers.buses.i2c_adapter import I2cAdapter
from stillarm.drivers.buses.parts import open_part

_adapters: dict[int, I2cAdapter] = {}
_waiting: dict[str, float] = {}


def open_memory_bus(name: str, wait_s: float) -> smbus2.SMBus:
    """Open the bus "memory:NAME", waiting up to `wait_s` for a rig to make the registers NAME.

    Raises UserError if there are none.
    """
    replaced = SimpleNamespace(open=_open, close=_close, O_RDWR=os.O_RDWR)
    vars(smbus2.smbus2).update(os=replaced, ioctl=_ioctl)
    _waiting[name] = wait_s
    try:
        return smbus2.SMBus(name)
    finally:
        del _waiting[name]


def _open(path: Any, flags: int) -> int:
    if path not in _waiting:
        return os.open(path, flags)
    adapter = open_part(path.partition(":")[2], _waiting[path])
    descriptor = os.open(os.devnull, flags)  # reserves a descriptor number
    _adapters[descriptor] = adapter
    return descriptor


def _close(descriptor: int) -> None:
    adapter = _adapters.pop(descriptor, None)
    if adapter is not None:
        adapter.close()
    os.close(descriptor)


def _ioctl(descriptor: int, request: int, argument: Any = 0) -> int:
    adapter = _adapters.get(descriptor)
    if adapter is None:
        return int(fcntl.ioctl(descriptor, request, argument))
    return adapter.ioctl(request, argument)
