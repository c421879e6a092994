"""Type, unit, meaning and bounds of a message's fields, read from its declaration; for datagrams and topics."""

from collections.abc import Iterable, Mapping
from typing import Any, get_type_hints

import msgspec
from msgspec import Meta

UNITS = {
    "rad_s2": "rad/s^2",
    "m_s3": "m/s^3",
    "m_s2": "m/s^2",
    "rad_s": "rad/s",
    "m_s": "m/s",
    "rad2": "rad^2",
    "px2": "px^2",
    "n_m": "N m",
    "rad": "rad",
    "px": "px",
    "hz": "Hz",
    "ns": "ns",
    "us": "us",
    "s": "s",
    "m": "m",
    "a": "A",
    "v": "V",
}
"""By a name's suffix, the longer ones first."""


def about(text: str) -> Meta:
    """A field's meaning, to stand in its Annotated type."""
    return Meta(description=text)


def plain_types(message: type[msgspec.Struct]) -> Mapping[str, Any]:
    """The fields' types by name, without what Annotated adds."""
    return get_type_hints(message)


def unit_of(name: str) -> str:
    """The unit that a field's name ends in; empty where it has none."""
    stem = name.removesuffix("_p50").removesuffix("_p99").removesuffix("_p999").removesuffix("_max")
    return next((unit for suffix, unit in UNITS.items() if stem.endswith(f"_{suffix}")), "")


def field_table(message: type[msgspec.Struct]) -> str:
    """A Markdown table of a message's fields, in their order."""
    hints = get_type_hints(message, include_extras=True)
    rows = ((f"`{name}`", *_told(name, kind, plain_types(message)[name])) for name, kind in hints.items())
    return markdown_table(("field", "type", "unit", "meaning"), rows)


def markdown_table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table, each line ended."""
    lines = [tuple(head), *map(tuple, rows)]
    lines.insert(1, ("---",) * len(lines[0]))
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def _told(name: str, kind: Any, plain: Any) -> tuple[str, str, str]:
    """Type with its bounds, unit, meaning."""
    notes = [note for note in getattr(kind, "__metadata__", ()) if isinstance(note, Meta)]
    bounds = [
        f"{sign} {value:g}"
        for note in notes
        for sign, value in ((">", note.gt), (">=", note.ge), ("<", note.lt), ("<=", note.le))
        if value is not None
    ]
    type_name = plain.__name__ if isinstance(plain, type) else str(plain).replace(" |", " or")
    meaning = " ".join(note.description for note in notes if note.description)
    return ", ".join([type_name, *bounds]), unit_of(name), meaning
