"""HDF5: plain, and as MATLAB 7.3 writes structs and cells."""

from pathlib import Path

import numpy as np
import pytest

from stillarm.tables.readers.hdf5_file import read

pytestmark = pytest.mark.slow  # h5py asks the system for its version, by a process
DATA = np.random.default_rng(0).normal(size=(40, 3))


def test_plain_groups_and_records(tmp_path: Path) -> None:
    import h5py

    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["rig/angles"] = DATA
        records = np.zeros(40, dtype=[("t", "f8"), ("n", "i4")])
        records["t"] = DATA[:, 2]
        file["log"] = records
    (table,) = read(tmp_path / "a.h5").tables
    np.testing.assert_array_equal(table.columns["rig.angles[:,1]"], DATA[:, 1])
    np.testing.assert_array_equal(table.columns["log.t"], DATA[:, 2])


def test_matlab_structs_and_cells_are_transposed(tmp_path: Path) -> None:
    import h5py

    with h5py.File(tmp_path / "a.mat", "w") as file:
        values = file.create_dataset("log/values", data=DATA.T)
        values.attrs["MATLAB_class"] = np.bytes_(b"double")
        file["log"].attrs["MATLAB_class"] = np.bytes_(b"struct")
        hidden = file.create_dataset("#refs#/a", data=DATA.T[[0]])
        hidden.attrs["MATLAB_class"] = np.bytes_(b"double")
        cells = file.create_dataset("cells", (1, 1), dtype=h5py.ref_dtype)
        cells[0, 0] = hidden.ref
        cells.attrs["MATLAB_class"] = np.bytes_(b"cell")
        word = file.create_dataset("word", data=np.zeros((30, 1), np.uint16))
        word.attrs["MATLAB_class"] = np.bytes_(b"char")
    (table,) = read(tmp_path / "a.mat").tables
    np.testing.assert_array_equal(table.columns["log.values(:,3)"], DATA[:, 2])
    np.testing.assert_array_equal(table.columns["cells{1}"], DATA[:, 0])
    assert len(table.columns) == 4
