"""Nine columns that are a rotation matrix: their rows are orthonormal, R R^T = I (a phone's rotation vector sensor)."""

from dataclasses import replace

import numpy as np

from stillarm.tables.guesses.column_look import ColumnLook
from stillarm.tables.roles import UNKNOWN
from stillarm.tables.table import Table, as_floats

ROTATION_MATRIX = "rotation matrix"
_ORTHONORMAL = 1e-3


def rotation_matrix(columns: list[ColumnLook], table: Table) -> list[ColumnLook]:
    """Name nine neighbouring columns of unknown quantity that are a rotation matrix, row by row."""
    unknown = [
        index for index, column in enumerate(columns) if column.quantity in (UNKNOWN, "position", "velocity")
    ]
    found = list(columns)
    for first in range(len(unknown) - 8):
        places = unknown[first : first + 9]
        if places[-1] - places[0] != 8:
            continue
        values = np.stack([as_floats(table.columns[columns[i].name]) for i in places], axis=1).reshape(
            -1, 3, 3
        )
        product = values @ values.transpose(0, 2, 1) - np.eye(3)
        if np.nanmax(np.abs(product), initial=0.0) < _ORTHONORMAL and np.isfinite(values).all():
            for number, place in enumerate(places):
                why = f"row {number // 3 + 1}, column {number % 3 + 1}: the nine are orthonormal in every row"
                found[place] = replace(columns[place], quantity=ROTATION_MATRIX, unit="1", why=(why,))
            break
    return found
