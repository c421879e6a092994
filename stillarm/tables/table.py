"""What a rectangular file holds, as values: tables of numeric columns, and what the file itself says of them."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Values = NDArray[Any]  # float64, or int64 where every value is whole and there


@dataclass(frozen=True)
class Table:
    """Columns of one length, by name, in the file's order.

    name: of the table in its file: an MCAP topic, "10000 rows" of a MAT file, empty in a CSV file
    columns: shape (rows,) each; float64 with NaN for no measurement, or int64
    units: what the file itself states as a column's unit, as it is written there
    rate_hz: sampling rate that the file states, or None
    """

    name: str
    columns: dict[str, Values]
    units: dict[str, str] = field(default_factory=dict)
    rate_hz: float | None = None

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self.columns.values()))) if self.columns else 0


@dataclass(frozen=True)
class TableFile:
    """A file's tables, and notes on what was left out or mended: lines that the user should read."""

    name: str
    format: str
    tables: tuple[Table, ...]
    notes: tuple[str, ...] = ()

    def largest(self) -> Table:
        """The table with most rows; among equals the one with most columns."""
        return max(self.tables, key=lambda table: (table.rows, len(table.columns)))


def as_floats(values: Values) -> NDArray[np.float64]:
    """A column as float64."""
    return np.asarray(values, dtype=np.float64)
