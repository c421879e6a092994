"""An emulated ICM-20948: its accelerometer. Not emulated: gyroscope, magnetometer, temperature, motion processor."""

import struct

from stillarm.drivers.emulated_chips.register_chip import ChipFifo, ChipLayout, ChipStatus
from stillarm.drivers.emulated_chips.shared_registers import SensedPart, Sensing

_BANK_2 = 2 * 128
_WHO_AM_I, _USER_CTRL, _POWER, _INT_ENABLE_1, _INT_STATUS_1, _DATA = 0x00, 0x03, 0x06, 0x11, 0x1A, 0x2D
_FIFO_EN_2, _FIFO_COUNT, _FIFO, _BANK_SELECT = 0x67, 0x70, 0x72, 0x7F
_DIVIDER_1, _DIVIDER_2, _ACCEL_CONFIG = _BANK_2 + 0x10, _BANK_2 + 0x11, _BANK_2 + 0x14
_FIFO_SAMPLES = 85  # 512 bytes


def _sensing(registers: memoryview) -> Sensing | None:
    if registers[_POWER] & 0x40:
        return None
    config = registers[_ACCEL_CONFIG]
    divider = (registers[_DIVIDER_1] & 0x0F) << 8 | registers[_DIVIDER_2]
    rate = 1125.0 / (1 + divider) if config & 1 else 4500.0
    return Sensing(rate, 16384.0 / (1 << (config >> 1 & 3)), -32768, 32767)


def _status(registers: memoryview, status: ChipStatus) -> int:
    return 0x01 if status.fresh and registers[_INT_ENABLE_1] & 0x01 else 0


ICM20948_CHIP = ChipLayout(
    sensed=SensedPart("icm20948", 6, {_WHO_AM_I: 0xEA, _POWER: 0x41, _ACCEL_CONFIG: 0x01}, _sensing),
    address=0x68,
    identity=range(_WHO_AM_I, _WHO_AM_I + 1),
    data=range(_DATA, _DATA + 6),
    encode=lambda registers, counts: struct.pack(">3h", *counts),
    status_register=_INT_STATUS_1,
    status=_status,
    read_frees=_INT_STATUS_1,
    read_only=frozenset((_WHO_AM_I, _INT_STATUS_1, *range(_DATA, _DATA + 6), _FIFO_COUNT, _FIFO_COUNT + 1)),
    bank_register=_BANK_SELECT,
    fifo=ChipFifo(
        on=lambda registers: bool(registers[_FIFO_EN_2] & 0x10 and registers[_USER_CTRL] & 0x40),
        depth=_FIFO_SAMPLES,
        window=_FIFO,
        streaming=True,
        counts=lambda status: {
            _FIFO_COUNT: 6 * status.entries >> 8,
            _FIFO_COUNT + 1: 6 * status.entries & 0xFF,
        },
    ),
)
