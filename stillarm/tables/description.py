"""The import description: which column is what, in which unit. `--look` writes it, and `--as` obeys it.

A scale that nobody knows is written `unit = "unknown"`. Such a channel keeps its own numbers and never gets into a
column that carries a unit.
"""

import difflib
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from stillarm.common.files.typed_toml import parse_toml, read_toml_text
from stillarm.common.user_error import UserError
from stillarm.tables.roles import BY_NAME, UNKNOWN
from stillarm.tables.units import UNITS, size_of

UNSTATED = "unknown"
NOTE_NAME = "import_description"  # where a recording's header keeps the text

TimeUnit = Literal["s", "ms", "us", "ns", "min"]
SECONDS: dict[str, float] = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}


class ChannelEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """[[tables.channels]]: value = scale * column + offset, in the role's own unit.

    unit: of the column. Gives the scale where none is given; "unknown": nobody knows the scale.
    scale: the role's unit per unit of the column, with sign
    """

    column: str
    role: str = UNKNOWN
    unit: str = ""
    scale: float | None = None
    offset: float = 0.0


class TableEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """[[tables]]: one of the file's tables.

    name: as `--look` prints it; empty where the file holds one table
    time_column: empty where no column tells the time; rows are counted at rate_hz then
    time_zero: in the time's unit, taken off before anything else
    rate_hz: rows per second; "unknown": time is counted in samples
    """

    name: str = ""
    time_column: str = ""
    time_unit: TimeUnit = "s"
    time_zero: int | float = 0
    rate_hz: Annotated[float, msgspec.Meta(gt=0.0)] | Literal["unknown"] | None = None
    channels: list[ChannelEntry] = []


class Description(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The whole file. source: the file that it was made for, for the reader only."""

    source: str = ""
    tables: list[TableEntry] = []


def load_description(path: str | Path) -> tuple[Description, str]:
    """A description and its text. Raises UserError, naming file, key, value and what is allowed."""
    text = read_toml_text(path)
    return parse_description(text, str(path)), text


def parse_description(text: str, name: str) -> Description:
    """A description from its text; `name` stands for the file in errors. Raises UserError."""
    description = parse_toml(text, Description, name)
    if not description.tables:
        raise UserError(
            f"{name}: no [[tables]]; `stillarm import FILE --look` writes a description to start from"
        )
    for table in description.tables:
        for channel in table.channels:
            _check(channel, name)
    return description


def _check(channel: ChannelEntry, name: str) -> None:
    where = f"{name}: channel {channel.column!r}"
    if channel.role not in BY_NAME:
        near = difflib.get_close_matches(channel.role, list(BY_NAME), n=1, cutoff=0.0)
        raise UserError(
            f"{where}: role = {channel.role!r}: no such role; the nearest is {near[0]}; docs/import.md lists them"
        )
    if channel.scale is not None and channel.scale == 0.0:
        raise UserError(f'{where}: scale = 0: a number other than 0 is needed, or unit = "unknown"')
    scale_of(channel, where)


def scale_of(channel: ChannelEntry, where: str = "") -> float | None:
    """The factor to the role's own unit; None where nobody knows it. Raises UserError for a unit that does not fit."""
    if channel.scale is not None:
        return channel.scale
    if channel.unit == UNSTATED:
        return None
    dimension = BY_NAME[channel.role].dimension
    if not channel.unit or not dimension:
        return 1.0
    size = size_of(channel.unit)
    if size is None:
        raise UserError(
            f'{where}: unit = {channel.unit!r}: not known; give scale, or unit = "unknown", or one of '
            f"{', '.join(unit for unit, (d, _) in UNITS.items() if d == dimension)}"
        )
    if size[0] != dimension:
        fitting = ", ".join(unit for unit, (d, _) in UNITS.items() if d == dimension)
        raise UserError(
            f"{where}: unit = {channel.unit!r} does not fit role {channel.role}; use one of {fitting}, or give scale"
        )
    return size[1]


def text_of(description: Description, notes: dict[tuple[str, str], str], head: list[str]) -> str:
    """The description as TOML. notes: a comment by table and column; head: lines at the top."""
    lines = [f"# {line}".rstrip() for line in head]
    lines.append(f"source = {_quoted(description.source)}")
    for table in description.tables:
        lines += ["", "[[tables]]", f"name = {_quoted(table.name)}"]
        lines.append(f"time_column = {_quoted(table.time_column)}")
        if table.time_column:
            lines.append(f"time_unit = {_quoted(table.time_unit)}")
            if table.time_zero:
                lines.append(f"time_zero = {table.time_zero!r}")
        if table.rate_hz is not None:
            rate = table.rate_hz if isinstance(table.rate_hz, str) else float(table.rate_hz)
            lines.append(f"rate_hz = {_quoted(rate) if isinstance(rate, str) else repr(rate)}")
        for channel in table.channels:
            lines += ["", "[[tables.channels]]"]
            note = notes.get((table.name, channel.column), "")
            lines += [f"# {note}"] if note else []
            lines += [f"column = {_quoted(channel.column)}", f"role = {_quoted(channel.role)}"]
            lines += [f"unit = {_quoted(channel.unit)}"] if channel.unit else []
            lines += [f"scale = {float(channel.scale)!r}"] if channel.scale is not None else []
            lines += [f"offset = {float(channel.offset)!r}"] if channel.offset else []
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    """A TOML basic string."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\u{ord(c):04X}" for c in escaped) + '"'
