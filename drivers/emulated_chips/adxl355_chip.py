"""An emulated ADXL355. Not emulated: external synchronisation, activity, self-test, offsets, high-pass filter."""

from stillarm.drivers.emulated_chips.register_chip import ChipFifo, ChipLayout, ChipStatus
from stillarm.drivers.emulated_chips.shared_registers import REGISTERS, SensedPart, Sensing

_DEVID, _STATUS, _FIFO_ENTRIES, _DATA, _FIFO_DATA = 0x00, 0x04, 0x05, 0x08, 0x11
_FILTER, _RANGE, _POWER, _RESET, _RESET_CODE = 0x28, 0x2C, 0x2D, 0x2F, 0x52
_POWER_UP = {0x00: 0xAD, 0x01: 0x1D, 0x02: 0xED, 0x03: 0x01, _RANGE: 0x81, _POWER: 0x01}
_HALF = 1 << 19


def _sensing(registers: memoryview) -> Sensing | None:
    scale = registers[_RANGE] & 3
    if registers[_POWER] & 0x01 or not scale:
        return None
    rate = 4000.0 / (1 << min(registers[_FILTER] & 0x0F, 10))
    return Sensing(rate, 256_000.0 / (1 << scale - 1), -_HALF, _HALF - 1)


def _encode(registers: memoryview, counts: tuple[int, int, int]) -> bytes:
    return b"".join((count << 4 & 0xFFFFFF).to_bytes(3, "big") for count in counts)


def _with_marker(registers: memoryview, counts: tuple[int, int, int]) -> bytes:
    data = bytearray(_encode(registers, counts))
    data[2] |= 0x01
    return bytes(data)


def _written(registers: memoryview, place: int, value: int) -> None:
    if place == _RESET and value == _RESET_CODE:
        registers[:REGISTERS] = bytes(REGISTERS)
        for register, default in _POWER_UP.items():
            registers[register] = default


def _status(registers: memoryview, status: ChipStatus) -> int:
    return int(status.fresh) | (0x02 if status.entries >= 32 else 0) | (0x04 if status.fifo_overrun else 0)


ADXL355_CHIP = ChipLayout(
    sensed=SensedPart("adxl355", 4, _POWER_UP, _sensing),
    address=0x1D,
    identity=range(_DEVID, _DEVID + 3),
    data=range(_DATA, _DATA + 9),
    encode=_encode,
    status_register=_STATUS,
    status=_status,
    read_frees=_DATA + 8,
    read_only=frozenset(range(_FIFO_DATA + 1)),
    fifo=ChipFifo(
        on=lambda registers: not registers[_POWER] & 0x01,
        depth=32,
        window=_FIFO_DATA,
        streaming=True,
        counts=lambda status: {_FIFO_ENTRIES: 3 * status.entries},
        entry=_with_marker,
    ),
    written=_written,
)
