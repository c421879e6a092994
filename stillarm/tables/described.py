"""From what `look` guesses to an import description, with the reasons as comments. Pure."""

from dataclasses import dataclass
from typing import Literal

from stillarm.tables.description import (
    SECONDS,
    UNSTATED,
    ChannelEntry,
    Description,
    TableEntry,
    TimeUnit,
    text_of,
)
from stillarm.tables.guesses.column_look import ColumnLook, TableLook
from stillarm.tables.roles import BY_NAME, IGNORE, INPUT, OUTPUT, UNKNOWN
from stillarm.tables.table import TableFile
from stillarm.tables.units import size_of

_HEAD = (
    "How to import {source}: written by `stillarm import --look`; correct it, then",
    "    stillarm import {source} --as THIS_FILE -o REC.mcap",
    "A channel's value in the recording is scale * column + offset; a known unit gives the scale.",
    'unit = "unknown": nobody knows the scale; the channel keeps its own numbers, and the scale is fitted.',
    'role = "unknown": kept under its own name. role = "ignore": left out. docs/import.md lists the roles.',
)

_SAME_CLOCK_S = 1e5  # from the clock's zero: a time this near is on the same clock


@dataclass(frozen=True)
class Described:
    """A description and its text with comments."""

    description: Description
    text: str


def described(file: TableFile, looks: tuple[TableLook, ...]) -> Described:
    """The description that the guesses give. A role goes to one channel of the whole file."""
    entries: dict[int, TableEntry] = {}
    notes: dict[tuple[str, str], str] = {}
    taken: set[str] = set()
    order = sorted(range(len(looks)), key=lambda i: (-_roles(looks[i]), -looks[i].rows))
    for number, index in enumerate(order):
        # Topics of one recording belong together; matrices of other lengths are other measurements.
        aside = number > 0 and (file.format != "mcap" or not _roles(looks[index]))
        entries[index] = _table_entry(looks[index], taken, notes, aside)
    tables = [entries[index] for index in range(len(looks))]
    description = Description(file.name, tables)
    head = [line.format(source=file.name) for line in _HEAD] + [f"note: {note}" for note in file.notes]
    return Described(description, text_of(description, notes, head))


def _roles(look: TableLook) -> int:
    return sum(column.role != UNKNOWN for column in look.columns)


def _table_entry(
    look: TableLook, taken: set[str], notes: dict[tuple[str, str], str], aside: bool
) -> TableEntry:
    """aside: leave the whole table out, and say which roles its columns could have."""
    clock, channels = look.clock, []
    rate: float | Literal["unknown"] | None = None
    if clock is None:
        rate = look.sampling.rate_hz if look.sampling and look.sampling.rate_hz else "unknown"
    pair_is_free = not {INPUT, OUTPUT} & taken
    for column in look.columns:
        if clock and column.name == clock.column:
            continue
        role = IGNORE if aside else column.role if column.role not in taken else UNKNOWN
        if role in (INPUT, OUTPUT) and not pair_is_free:
            role = UNKNOWN
        taken |= {role} - {UNKNOWN, IGNORE}
        channels.append(_channel(column, role, look))
        kind = f"{column.quantity}{', ' + column.kind if column.kind else ''}"
        reasons = "; ".join(
            (*column.why, *([f"could be {column.role}"] if aside and column.role != UNKNOWN else []))
        )
        notes[look.name, column.name] = f"{kind}: {reasons}" if reasons else kind
    unit: TimeUnit = clock.unit if clock else "s"  # type: ignore[assignment]
    return TableEntry(
        look.name, clock.column if clock else "", unit, clock.zero if clock else 0, rate, channels
    )


def _channel(column: ColumnLook, role: str, look: TableLook) -> ChannelEntry:
    dimension = BY_NAME[role].dimension
    if not dimension:
        return ChannelEntry(column.name, role, column.unit if role in (UNKNOWN, IGNORE) else "")
    size = size_of(column.unit) if column.unit else None
    unit = column.unit if size is not None and size[0] == dimension else UNSTATED
    zero_s = float(look.clock.zero) * SECONDS[look.clock.unit] if look.clock else 0.0
    same_clock = role == "started_s" and abs(column.shape.low - zero_s) < _SAME_CLOCK_S
    return ChannelEntry(column.name, role, unit, offset=-zero_s if same_clock else 0.0)
