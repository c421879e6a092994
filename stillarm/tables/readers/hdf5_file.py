"""HDF5 by h5py: MAT files of version 7.3, and plain HDF5.

MATLAB writes its matrices column by column, so that h5py shows them transposed; structs are groups, cells are datasets
of references (https://www.mathworks.com/help/matlab/import_export/mat-file-versions.html).
"""

import importlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from stillarm.tables.readers.array_groups import grouped
from stillarm.tables.readers.read_file import needed
from stillarm.tables.table import TableFile, Values

_DEPTH = 8


def read(path: Path) -> TableFile:
    """Read an HDF5 file. Raises UserError, with the remedy where h5py is not installed."""
    try:
        h5py = importlib.import_module("h5py")
    except ImportError:
        raise needed("h5py", f"{path}: HDF5 (MAT v7.3)", "mat73") from None
    with h5py.File(path, "r") as file:
        arrays = list(_leaves(h5py, file, file, "", _DEPTH))
        matlab = any("MATLAB_class" in item.attrs for item in file.values())
    style = "{name}(:,{one})" if matlab else "{name}[:,{zero}]"
    tables, notes = grouped(arrays, str(path), style)
    return TableFile(path.name, "mat" if matlab else "hdf5", tables, tuple(notes))


def _leaves(h5py: Any, file: Any, item: Any, name: str, depth: int) -> Iterator[tuple[str, Values]]:
    if depth == 0:
        return
    if isinstance(item, h5py.Group):
        for key, part in item.items():
            if not key.startswith("#"):  # #refs#, #subsystem#: MATLAB's own
                yield from _leaves(h5py, file, part, f"{name}.{key}" if name else key, depth - 1)
        return
    if not isinstance(item, h5py.Dataset) or item.attrs.get("MATLAB_class") == b"char" or item.shape is None:
        return
    if item.dtype == h5py.ref_dtype:
        for index, reference in enumerate(item[()].reshape(-1)):
            if reference:
                yield from _leaves(h5py, file, file[reference], f"{name}{{{index + 1}}}", depth - 1)
        return
    if item.attrs.get("MATLAB_empty", 0):
        return
    values = np.asarray(item[()])
    if values.dtype.names:
        for field in values.dtype.names:
            yield f"{name}.{field}", values[field]
        return
    yield name, values.T if "MATLAB_class" in item.attrs else values
