"""An emulated ADXL345. Not emulated: taps, activity, free fall, offsets, low power."""

import struct

from stillarm.drivers.emulated_chips.register_chip import ChipFifo, ChipLayout, ChipStatus
from stillarm.drivers.emulated_chips.shared_registers import SensedPart, Sensing

_DEVID, _BW_RATE, _POWER, _INT_SOURCE, _FORMAT, _DATA, _FIFO_CTL, _FIFO_STATUS = (
    0x00,
    0x2C,
    0x2D,
    0x30,
    0x31,
    0x32,
    0x38,
    0x39,
)
_FASTEST_HZ = 3200.0


def _sensing(registers: memoryview) -> Sensing | None:
    if not registers[_POWER] & 0x08:
        return None
    power = registers[_FORMAT] & 3
    bits = 10 + power if registers[_FORMAT] & 0x08 else 10  # full resolution: always 3.9 mg a count
    per_g = 256.0 if registers[_FORMAT] & 0x08 else 256.0 / (1 << power)
    half = 1 << bits - 1
    return Sensing(_FASTEST_HZ / (1 << 15 - (registers[_BW_RATE] & 0x0F)), per_g, -half, half - 1)


def _status(registers: memoryview, status: ChipStatus) -> int:
    return (0x80 if status.fresh or status.entries else 0) | (
        0x01 if status.overrun or status.fifo_overrun else 0
    )


ADXL345_CHIP = ChipLayout(
    sensed=SensedPart("adxl345", 3, {_DEVID: 0xE5, _BW_RATE: 0x0A}, _sensing),
    address=0x53,
    identity=range(_DEVID, _DEVID + 1),
    data=range(_DATA, _DATA + 6),
    encode=lambda registers, counts: struct.pack("<3h", *counts),
    status_register=_INT_SOURCE,
    status=_status,
    read_frees=_DATA + 5,
    read_only=frozenset((_DEVID, _INT_SOURCE, _FIFO_STATUS, *range(_DATA, _DATA + 6))),
    fifo=ChipFifo(
        on=lambda registers: registers[_FIFO_CTL] >> 6 == 2,
        depth=33,
        window=_DATA,
        streaming=False,
        counts=lambda status: {_FIFO_STATUS: min(status.entries, 33)},
    ),
)
