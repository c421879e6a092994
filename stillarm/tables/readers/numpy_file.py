"""NumPy's npy and npz files: vectors, matrices, and records with named fields. Pickled objects are refused."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from stillarm.common.user_error import UserError
from stillarm.tables.readers.array_groups import grouped
from stillarm.tables.table import TableFile, Values


def read(path: Path) -> TableFile:
    """Read a npy or npz file. Raises UserError, or what NumPy raises on a damaged one."""
    held = np.load(path, allow_pickle=False)
    named = held.items() if isinstance(held, np.lib.npyio.NpzFile) else [("", held)]
    try:
        arrays = [leaf for name, value in named for leaf in _leaves(name, value)]
    except ValueError as error:
        if "pickle" in str(error):
            raise UserError(
                f"{path}: holds pickled objects, which may run code; save plain arrays (numpy.savez)"
            ) from None
        raise
    style = "column {one}" if isinstance(held, np.ndarray) else "{name}[:,{zero}]"
    tables, notes = grouped(arrays, str(path), style)
    return TableFile(path.name, "numpy", tables, tuple(notes))


def _leaves(name: str, value: Values) -> Iterator[tuple[str, Values]]:
    if value.dtype.names:
        for field in value.dtype.names:
            yield f"{name}.{field}" if name else field, value[field]
    elif value.dtype.kind in "mM":
        yield name or "column 1", value.astype(f"{value.dtype.kind}8[ns]").astype(np.int64)
    else:
        yield name if name or value.ndim > 1 else "column 1", value
