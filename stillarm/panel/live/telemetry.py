"""The datagrams of docs/telemetry.md as values. Pure: bytes in, rows out; a datagram that does not fit is refused as a
whole."""

from math import nan
from typing import Any

import msgspec


class Fast(msgspec.Struct, frozen=True, gc=False):
    """The fields of /fast that the page draws; units as in docs/topics.md."""

    acceleration_m_s2: float = nan
    joint_velocity_command_rad_s: float = nan
    joint_velocity_reference_rad_s: float = nan
    joint_position_rad: float = nan
    damping_allowed: bool = False


class Estimate(msgspec.Struct, frozen=True, gc=False):
    """The fields of /estimate that the page draws."""

    deflection_m: float = nan
    deflection_std_m: float = nan
    delay_s: float = nan
    delay_std_s: float = nan
    damping_rad_s: float = nan


class Visual(msgspec.Struct, frozen=True, gc=False):
    """The fields of /frames that the page draws."""

    displacement_px: float = nan
    features: int = 0
    inliers: int = 0
    status: int = 0


class Words(msgspec.Struct, frozen=True):
    """The texts of /estimate, the settings in force, and cycle 0 on the controller's monotonic clock, s."""

    state: str = ""
    reason: str = ""
    damping_status: str = ""
    delay_status: str = ""
    deflection_status: str = ""
    estimate_reason: str = ""
    trust: str = ""
    method: str = ""
    added_damping_ratio: float = nan
    origin_monotonic_s: float = nan


class Line(msgspec.Struct, frozen=True):
    """One line of /log."""

    level: str
    text: str


class Row(msgspec.Struct, frozen=True, gc=False):
    """One map: a time, s on the controller's clock, and one of the others."""

    time_s: float = nan
    fast: Fast | None = None
    estimate: Estimate | None = None
    frames: Visual | None = None
    link: dict[str, Any] | None = None
    words: Words | None = None
    log: Line | None = None
    loop_second: dict[str, Any] | None = None


_DECODER = msgspec.msgpack.Decoder(list[Row])


def rows_of(datagram: bytes) -> list[Row]:
    """The rows of a datagram; none where it is not telemetry."""
    try:
        return _DECODER.decode(datagram)
    except (msgspec.DecodeError, msgspec.ValidationError, UnicodeDecodeError):
        return []
