"""npy and npz: matrices, instants, and pickles, which are refused."""

from pathlib import Path

import numpy as np
import pytest

from stillarm.common.user_error import UserError
from stillarm.tables.readers.numpy_file import read
from stillarm.tables.readers.read_file import read_table_file


def test_a_matrix_is_as_many_columns_as_its_shorter_side(tmp_path: Path) -> None:
    matrix = np.random.default_rng(0).normal(size=(3, 100))
    np.save(tmp_path / "a.npy", matrix)
    (table,) = read(tmp_path / "a.npy").tables
    np.testing.assert_array_equal(table.columns["column 2"], matrix[1])


def test_instants_become_nanoseconds(tmp_path: Path) -> None:
    stamps = np.datetime64("2024-05-01T12:00:00", "ms") + np.arange(20)
    np.savez(tmp_path / "a.npz", stamps=stamps, x=np.arange(20.0))
    (table,) = read(tmp_path / "a.npz").tables
    assert np.diff(table.columns["stamps"]).tolist() == [1_000_000] * 19


@pytest.mark.parametrize("name", ["a.npy", "a.npz"])
def test_pickles_are_refused_unread(tmp_path: Path, name: str) -> None:
    held = np.array([{"a": 1}] * 20, dtype=object)
    (np.save if name == "a.npy" else np.savez)(tmp_path / name, held)
    with pytest.raises(UserError, match=r"pickle"):
        read_table_file(tmp_path / name)
