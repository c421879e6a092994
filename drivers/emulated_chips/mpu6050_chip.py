"""An emulated MPU-6050: its accelerometer. Not emulated: gyroscope, temperature, motion detection, auxiliary bus."""

import struct

from stillarm.drivers.emulated_chips.register_chip import ChipFifo, ChipLayout, ChipStatus
from stillarm.drivers.emulated_chips.shared_registers import SensedPart, Sensing

_DIVIDER, _CONFIG, _ACCEL_CONFIG, _FIFO_EN, _INT_ENABLE = 0x19, 0x1A, 0x1C, 0x23, 0x38
_INT_STATUS, _DATA, _USER_CTRL, _POWER, _FIFO_COUNT, _FIFO, _WHO_AM_I = (
    0x3A,
    0x3B,
    0x6A,
    0x6B,
    0x72,
    0x74,
    0x75,
)
_FIFO_SAMPLES = 170  # 1024 bytes
_ACCELEROMETER_HZ = 1000.0


def _sensing(registers: memoryview) -> Sensing | None:
    if registers[_POWER] & 0x40:
        return None
    gyroscope_hz = 8000.0 if registers[_CONFIG] & 7 in (0, 7) else 1000.0
    rate = min(gyroscope_hz / (1 + registers[_DIVIDER]), _ACCELEROMETER_HZ)
    return Sensing(rate, 16384.0 / (1 << (registers[_ACCEL_CONFIG] >> 3 & 3)), -32768, 32767)


def _status(registers: memoryview, status: ChipStatus) -> int:
    ready = status.fresh and registers[_INT_ENABLE] & 0x01
    return (0x01 if ready else 0) | (0x10 if status.fifo_overrun else 0)


def _written(registers: memoryview, place: int, value: int) -> None:
    if place == _USER_CTRL and value & 0x04:
        registers[_USER_CTRL] = value & ~0x44  # reset, which takes effect while the FIFO is off


MPU6050_CHIP = ChipLayout(
    sensed=SensedPart("mpu6050", 5, {_WHO_AM_I: 0x68, _POWER: 0x40}, _sensing),
    address=0x68,
    identity=range(_WHO_AM_I, _WHO_AM_I + 1),
    data=range(_DATA, _DATA + 6),
    encode=lambda registers, counts: struct.pack(">3h", *counts),
    status_register=_INT_STATUS,
    status=_status,
    read_frees=_INT_STATUS,
    read_only=frozenset((_WHO_AM_I, *range(_INT_STATUS, 0x61), _FIFO_COUNT, _FIFO_COUNT + 1)),
    fifo=ChipFifo(
        on=lambda registers: bool(registers[_FIFO_EN] & 0x08 and registers[_USER_CTRL] & 0x40),
        depth=_FIFO_SAMPLES,
        window=_FIFO,
        streaming=True,
        counts=lambda status: {
            _FIFO_COUNT: 6 * status.entries >> 8,
            _FIFO_COUNT + 1: 6 * status.entries & 0xFF,
        },
    ),
    written=_written,
)
