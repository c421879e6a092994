"""MAT files up to version 7, by scipy.io: matrices, and structs in structs (Simulink's "structure with time")."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from stillarm.tables.readers.array_groups import grouped
from stillarm.tables.table import TableFile, Values

_DEPTH = 8


def read(path: Path) -> TableFile:
    """Read a MAT file. Raises UserError, or what scipy raises on a damaged one."""
    import scipy.io

    held = scipy.io.loadmat(str(path), chars_as_strings=True)
    named = ((name, value) for name, value in held.items() if not name.startswith("__"))
    arrays = [leaf for name, value in named for leaf in _leaves(name, value, _DEPTH)]
    tables, notes = grouped(arrays, str(path), "{name}(:,{one})")
    return TableFile(path.name, "mat", tables, tuple(notes))


def _leaves(name: str, value: Any, depth: int) -> Iterator[tuple[str, Values]]:
    """The arrays in a struct or cell, with names as MATLAB writes them."""
    if not isinstance(value, np.ndarray) or depth == 0:
        return
    if value.dtype.names:
        for index, record in enumerate(value.reshape(-1)):
            at = f"({index + 1})" if value.size > 1 else ""
            for field in value.dtype.names:
                yield from _leaves(f"{name}{at}.{field}", record[field], depth - 1)
    elif value.dtype.kind == "O":
        for index, cell in enumerate(value.reshape(-1)):
            at = f"{{{index + 1}}}" if value.size > 1 else ""
            yield from _leaves(f"{name}{at}", cell, depth - 1)
    else:
        yield name, value
