"""An emulated LIS3DH. Not emulated: low power, self-test, high-pass filter, interrupts, auxiliary converter."""

import struct

from stillarm.drivers.emulated_chips.register_chip import ChipFifo, ChipLayout, ChipStatus
from stillarm.drivers.emulated_chips.shared_registers import SensedPart, Sensing

_WHO_AM_I, _CTRL1, _CTRL4, _CTRL5, _STATUS, _OUT, _FIFO_CTRL, _FIFO_SRC = (
    0x0F,
    0x20,
    0x23,
    0x24,
    0x27,
    0x28,
    0x2E,
    0x2F,
)
_RATES_HZ = (0.0, 1.0, 10.0, 25.0, 50.0, 100.0, 200.0, 400.0, 1600.0, 1344.0)
_MG_PER_COUNT_12 = (1.0, 2.0, 4.0, 12.0)


def _bits(registers: memoryview) -> int:
    return 12 if registers[_CTRL4] & 0x08 else 10


def _sensing(registers: memoryview) -> Sensing | None:
    rate = registers[_CTRL1] >> 4
    if not 0 < rate < len(_RATES_HZ) or registers[_CTRL1] & 0x07 != 0x07:
        return None
    bits = _bits(registers)
    per_g = 1000.0 / _MG_PER_COUNT_12[registers[_CTRL4] >> 4 & 3] / (1 << 12 - bits)
    half = 1 << bits - 1
    return Sensing(_RATES_HZ[rate], per_g, -half, half - 1)


def _encode(registers: memoryview, counts: tuple[int, int, int]) -> bytes:
    shift = 16 - _bits(registers)
    order = ">3h" if registers[_CTRL4] & 0x40 else "<3h"
    return struct.pack(order, *(count << shift for count in counts))


def _status(registers: memoryview, status: ChipStatus) -> int:
    return (0x0F if status.fresh else 0) | (0xF0 if status.overrun else 0)


def _fifo_source(status: ChipStatus) -> dict[int, int]:
    entries = status.entries
    return {_FIFO_SRC: (0x40 if entries >= 32 else 0) | (0x20 if entries == 0 else 0) | min(entries, 31)}


LIS3DH_CHIP = ChipLayout(
    sensed=SensedPart("lis3dh", 2, {_WHO_AM_I: 0x33, _CTRL1: 0x07}, _sensing),
    address=0x18,
    identity=range(_WHO_AM_I, _WHO_AM_I + 1),
    data=range(_OUT, _OUT + 6),
    encode=_encode,
    status_register=_STATUS,
    status=_status,
    read_frees=_OUT + 5,
    read_only=frozenset((_WHO_AM_I, _FIFO_SRC, *range(_STATUS, _OUT + 6))),
    auto_increment_bit=0x80,
    fifo=ChipFifo(
        on=lambda registers: bool(registers[_CTRL5] & 0x40 and registers[_FIFO_CTRL] & 0xC0 == 0x80),
        depth=32,
        window=_OUT,
        streaming=False,
        counts=_fifo_source,
        rolls=True,
    ),
)
