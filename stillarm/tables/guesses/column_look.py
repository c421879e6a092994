"""The properties found of a column and of a table."""

from dataclasses import dataclass

from stillarm.tables.guesses.shape import Shape
from stillarm.tables.guesses.time_column import Clock, Sampling


@dataclass(frozen=True)
class ColumnLook:
    """One column: its values' shape, the guess, and why."""

    name: str
    shape: Shape
    quantity: str
    kind: str
    part: str
    unit: str
    role: str
    why: tuple[str, ...] = ()


@dataclass(frozen=True)
class TableLook:
    """One table. clock: None where no column tells the time; sampling's rate_hz is the file's own then, or None."""

    name: str
    rows: int
    clock: Clock | None
    sampling: Sampling | None
    columns: tuple[ColumnLook, ...]
    notes: tuple[str, ...] = ()
