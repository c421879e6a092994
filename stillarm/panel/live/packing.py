"""Packs rows as binary messages for the page: a head, the times as float64, then one column of float32 after another.
Pure.

Head, little-endian: kind (u8), columns (u8), rows (u16), 4 bytes unused. page/samples.js reads it.
"""

import struct
from array import array
from collections.abc import Sequence

from stillarm.panel.live.telemetry import Row

_HEAD = struct.Struct("<BBHI")
MOST_ROWS = 65_535
FAST_COLUMNS = (
    "acceleration_m_s2",
    "joint_velocity_command_rad_s",
    "joint_velocity_reference_rad_s",
    "joint_position_rad",
)
ESTIMATE_COLUMNS = ("deflection_m", "deflection_std_m", "delay_s", "delay_std_s", "damping_rad_s")
FRAME_COLUMNS = ("displacement_px", "features", "inliers", "status")
KINDS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("fast", FAST_COLUMNS),
    ("estimate", ESTIMATE_COLUMNS),
    ("frames", FRAME_COLUMNS),
)
"""The kinds of message, by number from 0, with their columns."""


def packed(kind: int, times_s: Sequence[float], columns: Sequence[Sequence[float]]) -> bytes:
    """One message. times_s: (n,), s; columns: each (n,), in the order of KINDS. n is at most MOST_ROWS."""
    head = _HEAD.pack(kind, len(columns), len(times_s), 0)
    return b"".join((head, array("d", times_s).tobytes(), *(array("f", c).tobytes() for c in columns)))


def pack_rows(rows: list[Row]) -> list[bytes]:
    """The messages of a datagram's rows: at most one for each kind."""
    messages = []
    for kind, (topic, names) in enumerate(KINDS):
        found = [(row.time_s, values) for row in rows if (values := getattr(row, topic)) is not None]
        if found:
            columns = [[getattr(values, name) for _, values in found] for name in names]
            messages.append(packed(kind, [time_s for time_s, _ in found], columns))
    return messages
