"""Parquet by pyarrow: columns of numbers, instants as ns, lists of one length as columns of their own."""

import importlib
from pathlib import Path
from typing import Any

import numpy as np

from stillarm.common.user_error import UserError
from stillarm.tables.readers.array_groups import MAX_COLUMNS, plain
from stillarm.tables.readers.read_file import needed
from stillarm.tables.table import Table, TableFile, Values


def read(path: Path) -> TableFile:
    """Read a Parquet file. Raises UserError, with the remedy where pyarrow is not installed."""
    try:
        parquet = importlib.import_module("pyarrow.parquet")
        arrow = importlib.import_module("pyarrow")
    except ImportError:
        raise needed("pyarrow", f"{path}: Parquet", "parquet") from None
    held = parquet.read_table(path)
    columns: dict[str, Values] = {}
    units: dict[str, str] = {}
    notes: list[str] = []
    for name, column in zip(held.column_names, held.columns, strict=True):
        found = _columns(arrow, name, column)
        if not found:
            notes.append(f"{name}: {column.type}, no numbers; left out")
        columns |= found
        if arrow.types.is_timestamp(column.type) or arrow.types.is_duration(column.type):
            units[name] = "ns"
    if not columns or held.num_rows == 0:
        raise UserError(f"{path}: no rows of numbers; a table of numbers is needed")
    return TableFile(path.name, "parquet", (Table("", columns, units),), tuple(notes))


def _columns(arrow: Any, name: str, column: Any) -> dict[str, Values]:
    kind, types = column.type, arrow.types
    if types.is_timestamp(kind) or types.is_duration(kind):
        to = arrow.timestamp("ns", kind.tz) if types.is_timestamp(kind) else arrow.duration("ns")
        column = column.cast(to).cast(arrow.int64())
    elif types.is_boolean(kind):
        column = column.cast(arrow.int8())
    elif types.is_decimal(kind):
        column = column.cast(arrow.float64())
    elif types.is_fixed_size_list(kind) or types.is_list(kind):
        return _listed(name, column.to_pylist())
    elif not (types.is_integer(kind) or types.is_floating(kind)):
        return {}
    if column.null_count and types.is_integer(column.type):
        column = column.cast(arrow.float64(), safe=False)
    values = column.to_numpy()
    return {name: plain(np.asarray(values))}


def _listed(name: str, rows: list[Any]) -> dict[str, Values]:
    widths = {len(row) for row in rows if row is not None}
    if len(widths) != 1 or not 0 < (width := widths.pop()) <= MAX_COLUMNS:
        return {}
    empty = [None] * width
    try:
        matrix = np.array([row or empty for row in rows], dtype=np.float64)
    except (TypeError, ValueError):
        return {}
    return {f"{name}[{i}]": plain(matrix[:, i]) for i in range(width)}
