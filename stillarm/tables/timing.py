"""A table's time in seconds, by what the description says. Pure."""

import numpy as np
from numpy.typing import NDArray

from stillarm.common.user_error import UserError
from stillarm.tables.description import SECONDS, UNSTATED, TableEntry
from stillarm.tables.table import Table, as_floats

MAX_TIME_S = 9e9  # what fits a log time in nanoseconds


def times_s(table: Table, entry: TableEntry, where: str) -> NDArray[np.float64]:
    """Time of each row, s, shape (rows,); NaN where the file holds none. Raises UserError.

    Integers are subtracted as integers: nanoseconds since 1970 keep their last digit.
    """
    if not entry.time_column:
        return np.arange(table.rows) / _rate_hz(table, entry, where)
    if entry.time_column not in table.columns:
        raise UserError(
            f"{where}: time_column = {entry.time_column!r}: no such column; it holds {listed(table)}"
        )
    values = table.columns[entry.time_column]
    since = (
        values - int(entry.time_zero)
        if _whole(values, entry.time_zero)
        else as_floats(values) - entry.time_zero
    )
    seconds = as_floats(since) * SECONDS[entry.time_unit]
    if np.nanmax(np.abs(seconds), initial=0.0) > MAX_TIME_S:
        raise UserError(
            f"{where}: time_column {entry.time_column!r} reaches {np.nanmax(np.abs(seconds)):.3g} s; at most "
            f"{MAX_TIME_S:g} s; correct time_unit, or give time_zero"
        )
    return seconds


def _whole(values: NDArray[np.generic], zero: float) -> bool:
    return values.dtype.kind == "i" and float(zero).is_integer()


def _rate_hz(table: Table, entry: TableEntry, where: str) -> float:
    if entry.rate_hz == UNSTATED:
        return 1.0
    rate = entry.rate_hz or table.rate_hz
    if rate is None:
        raise UserError(
            f'{where}: no time_column and no rate_hz; give the sampling rate, or "unknown" to count in samples'
        )
    return float(rate)


def listed(table: Table) -> str:
    """The table's columns for a message."""
    names = list(table.columns)
    return ", ".join(names[:12]) + (f" and {len(names) - 12} more" if len(names) > 12 else "")
