"""Parquet columns of many types."""

from pathlib import Path

import numpy as np
import pyarrow
from pyarrow.parquet import write_table

from stillarm.tables.readers.parquet_file import read


def test_instants_lists_gaps_and_words(tmp_path: Path) -> None:
    columns = {
        "when": pyarrow.array([1_700_000_000_000 + 2 * i for i in range(20)], pyarrow.timestamp("ms")),
        "force": pyarrow.array([[float(i), -1.0] for i in range(20)]),
        "count": pyarrow.array([None, *range(19)], pyarrow.int32()),
        "on": pyarrow.array([True, False] * 10),
        "who": pyarrow.array(["me"] * 20),
    }
    write_table(pyarrow.table(columns), tmp_path / "a.parquet")
    file = read(tmp_path / "a.parquet")
    (table,) = file.tables
    assert table.columns["when"][1] - table.columns["when"][0] == 2_000_000 and table.units["when"] == "ns"
    assert table.columns["force[0]"].tolist() == list(range(20)) and set(table.columns["force[1]"]) == {-1.0}
    assert np.isnan(table.columns["count"][0]) and table.columns["on"].tolist() == [1, 0] * 10
    assert any(note.startswith("who: string") for note in file.notes)
