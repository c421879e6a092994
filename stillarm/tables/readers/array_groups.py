"""Arrays of any shape by name, as in MAT, HDF5 and NumPy files, sorted into tables: one for each number of rows.

A vector is a column. A matrix is as many columns as its shorter side has, if that is at most MAX_COLUMNS. An
array shorter than MIN_ROWS is a parameter, not a measurement.
"""

import re
from collections.abc import Iterable

import numpy as np

from stillarm.common.user_error import UserError
from stillarm.tables.table import Table, Values, as_floats

MAX_COLUMNS = 64
MIN_ROWS = 16
_RATE = re.compile(
    r"(fs|f_s|fsample|fsamp|freq_?sampling|sampl\w*_?(rate|freq\w*)(_?hz)?|rate(_?hz)?)", re.IGNORECASE
)
_PERIOD = re.compile(r"(ts|t_s|dt|delta_?t|sampl\w*_?(time|period)(_?s)?|cycle(_?s)?)", re.IGNORECASE)


def grouped(
    arrays: Iterable[tuple[str, Values]], where: str, style: str
) -> tuple[tuple[Table, ...], list[str]]:
    """Tables of named arrays, and notes. style: of a matrix's column: 'name(:,{one})' or 'name[:,{zero}]'.

    Raises UserError when no array has MIN_ROWS rows.
    """
    groups: dict[int, dict[str, Values]] = {}
    notes: list[str] = []
    rate_hz = None
    for name, array in arrays:
        if array.dtype.kind not in "fiub":
            if array.size >= MIN_ROWS:
                notes.append(f"{name}: {_KINDS.get(array.dtype.kind, 'no numbers')}; left out")
            continue
        rate_hz = _stated_rate(name, array) or rate_hz
        for column, values in _columns(name, array, style, notes):
            groups.setdefault(len(values), {})[column] = values
    if not groups:
        raise UserError(
            f"{where}: no array of numbers with {MIN_ROWS} rows or more; a table of numbers is needed"
        )
    single = len(groups) == 1
    tables = tuple(
        Table("" if single else f"{rows} rows", columns, rate_hz=rate_hz) for rows, columns in groups.items()
    )
    return tables, notes


_KINDS = {"c": "complex numbers", "U": "text", "S": "text", "O": "objects", "V": "records"}


def _columns(name: str, array: Values, style: str, notes: list[str]) -> list[tuple[str, Values]]:
    matrix = array.reshape(len(array), -1) if array.ndim > 2 else np.atleast_2d(array)
    if array.ndim == 1 or (matrix.shape[0] < matrix.shape[1] and array.ndim == 2):
        matrix = matrix.T
    rows, width = matrix.shape
    if rows < MIN_ROWS:
        return []
    if width > MAX_COLUMNS:
        notes.append(
            f"{name}: {rows} x {width} values, no table of channels (at most {MAX_COLUMNS}); left out"
        )
        return []
    names = [style.format(name=name, one=i + 1, zero=i) for i in range(width)] if width > 1 else [name]
    return [(column, plain(matrix[:, i])) for i, column in enumerate(names)]


def plain(values: Values) -> Values:
    """A column as int64 where whole and not too large, else float64 without infinities."""
    if values.dtype.kind in "ib" or (values.dtype.kind == "u" and (values.size == 0 or values.max() < 2**63)):
        return values.astype(np.int64)
    floats = as_floats(values)
    return np.where(np.isfinite(floats), floats, np.nan)


def _stated_rate(name: str, array: Values) -> float | None:
    if array.size != 1:
        return None
    value = float(array.reshape(-1)[0])
    word = name.rpartition(".")[2]
    if not np.isfinite(value) or value <= 0.0:
        return None
    if _RATE.fullmatch(word):
        return value
    return 1.0 / value if _PERIOD.fullmatch(word) else None
