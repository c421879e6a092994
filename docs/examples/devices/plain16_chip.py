"""The emulated PLAIN16."""

import struct

from stillarm.drivers.emulated_chips.register_chip import ChipLayout
from stillarm.drivers.emulated_chips.shared_registers import SensedPart, Sensing


def _sensing(registers: memoryview) -> Sensing | None:
    control = registers[0x01]
    return Sensing(1000.0, 8192.0 if control & 0x01 else 16384.0, -32768, 32767) if control & 0x80 else None


PLAIN16_CHIP = ChipLayout(
    sensed=SensedPart("plain16", 7, {0x00: 0x16}, _sensing),
    address=0x20,
    identity=range(0x00, 0x01),
    data=range(0x03, 0x09),
    encode=lambda registers, counts: struct.pack("<3h", *counts),
    status_register=0x02,
    status=lambda registers, status: int(status.fresh),
    read_frees=0x08,
    read_only=frozenset((0x00, *range(0x02, 0x09))),
)
