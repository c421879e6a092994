"""Layout of a record in an industrial I/O buffer: the position of each channel and the meaning of its bits.

The kernel orders the enabled channels by index. It aligns each to its own size, and the record to the largest.
"""

import re
from dataclasses import dataclass
from math import nan
from pathlib import Path

from stillarm.common.user_error import UserError

_TYPE = re.compile(
    r"(?P<order>le|be):(?P<sign>[su])(?P<bits>\d+)/(?P<storage>\d+)(?:X1)?(?:>>(?P<shift>\d+))?"
)
_TIMESTAMP = "in_timestamp"


@dataclass(frozen=True)
class Channel:
    """A number in a record: `bits` wide, shifted by `shift` from the right, in `size` bytes at offset `at`."""

    at: int
    size: int
    big_endian: bool
    signed: bool
    bits: int
    shift: int

    def decode(self, record: bytes) -> int:
        """The number."""
        stored = int.from_bytes(record[self.at : self.at + self.size], "big" if self.big_endian else "little")
        value = stored >> self.shift & (1 << self.bits) - 1
        return value - (1 << self.bits) if self.signed and value >> self.bits - 1 else value


@dataclass(frozen=True)
class IioRecord:
    """A record's size, its three axes, and the kernel's time stamp if it is enabled."""

    size: int
    axes: tuple[Channel, ...]
    timestamp: Channel | None

    @property
    def limits(self) -> tuple[float, ...]:
        """The largest count of each axis."""
        return tuple(float(1 << axis.bits - 1 if axis.signed else 1 << axis.bits) for axis in self.axes)

    def decode(self, record: bytes) -> tuple[list[float], float]:
        """(counts of the axes, the kernel's time, s)."""
        stamp = nan if self.timestamp is None else self.timestamp.decode(record) * 1e-9
        return [float(axis.decode(record)) for axis in self.axes], stamp


def read_layout(elements: Path, axes: tuple[str, ...]) -> IioRecord:
    """The layout that the folder scan_elements describes. Raises UserError if it does not follow the ABI."""
    enabled = {}
    for switch in elements.glob("*_en"):
        name = switch.name.removesuffix("_en")
        if switch.read_text().strip() == "1":
            enabled[int((elements / f"{name}_index").read_text())] = name
    channels: dict[str, Channel] = {}
    at, largest = 0, 1
    for index in sorted(enabled):
        name = enabled[index]
        text = (elements / f"{name}_type").read_text().strip()
        found = _TYPE.fullmatch(text)
        if found is None:
            raise UserError(f"{elements / f'{name}_type'}: {text!r}: not a type such as 'le:s16/16>>0'")
        size = int(found["storage"]) // 8
        at += -at % size
        channels[name] = Channel(
            at,
            size,
            found["order"] == "be",
            found["sign"] == "s",
            int(found["bits"]),
            int(found["shift"] or 0),
        )
        at += size
        largest = max(largest, size)
    missing = [axis for axis in axes if axis not in channels]
    if missing:
        raise UserError(f"{elements}: no channel {missing[0]}; name another accelerometer.device")
    return IioRecord(at + -at % largest, tuple(channels[axis] for axis in axes), channels.get(_TIMESTAMP))
