"""MAT files with structs, cells, matrices either way round, and parameters beside the data."""

from pathlib import Path

import numpy as np
import pytest
import scipy.io

from stillarm.common.user_error import UserError
from stillarm.tables.readers.array_groups import grouped
from stillarm.tables.readers.mat_file import read

DATA = np.random.default_rng(0).normal(size=(40, 3))


def test_structs_cells_and_matrices(tmp_path: Path) -> None:
    cell = np.empty((1, 2), dtype=object)
    cell[0, 0], cell[0, 1] = DATA[:, [0]], DATA[:, [1]]
    held = {"log": {"time": np.arange(40.0), "signals": {"values": DATA}}, "flat": DATA.T, "cells": cell}
    scipy.io.savemat(tmp_path / "a.mat", held | {"fs": 250.0, "note": "by hand", "A": np.eye(4)})
    (table,) = read(tmp_path / "a.mat").tables
    assert table.rate_hz == 250.0
    for index in range(3):
        np.testing.assert_array_equal(table.columns[f"log.signals.values(:,{index + 1})"], DATA[:, index])
        np.testing.assert_array_equal(table.columns[f"flat(:,{index + 1})"], DATA[:, index])
    np.testing.assert_array_equal(table.columns["cells{2}"], DATA[:, 1])
    assert table.columns["log.time"].tolist() == list(range(40))


def test_arrays_of_other_lengths_are_tables_of_their_own(tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "a.mat", {"a": np.arange(30.0), "b": np.arange(50.0), "Ts": 0.01})
    tables = read(tmp_path / "a.mat").tables
    assert {table.name: list(table.columns) for table in tables} == {"30 rows": ["a"], "50 rows": ["b"]}
    assert all(table.rate_hz == 100.0 for table in tables)


def test_what_is_no_channel_is_said_or_refused() -> None:
    _, notes = grouped(
        [("x", DATA), ("image", np.zeros((70, 90))), ("z", np.zeros(20, complex))], "f", "{name}[:,{zero}]"
    )
    assert any("image" in note and "at most 64" in note for note in notes) and any(
        "complex" in note for note in notes
    )
    with pytest.raises(UserError, match="no array of numbers with 16 rows"):
        grouped([("A", np.eye(4))], "f", "{name}")
