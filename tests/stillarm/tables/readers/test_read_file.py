"""Every format: the numbers that the test wrote come back; damaged files and absent packages give one line."""

import importlib
from pathlib import Path

import numpy as np
import pytest

from stillarm.common.user_error import UserError
from stillarm.tables.readers.read_file import read_table_file
from stillarm.tables.table import as_floats
from tests.stillarm.tables import written

# h5py asks the system for its version when it is first imported, by a process.
FORMATS = [pytest.param(n, marks=pytest.mark.slow) if n == "v73.mat" else n for n in written.WRITERS]


@pytest.mark.parametrize("name", FORMATS)
def test_the_same_numbers_come_back(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    written.WRITERS[name](path)
    (table,) = read_table_file(path).tables
    for column, values in written.numbers().items():
        np.testing.assert_array_equal(as_floats(table.columns[column]), values)


def test_a_ros2_bag_gives_its_numbers_by_joint(tmp_path: Path) -> None:
    written.ros2_bag(tmp_path / "bag")
    (table,) = read_table_file(tmp_path / "bag").tables
    assert table.name == "/joint_states"
    numbers = written.numbers()
    np.testing.assert_array_equal(as_floats(table.columns["position.shoulder"]), numbers["theta"])
    np.testing.assert_array_equal(as_floats(table.columns["effort.shoulder"]), numbers["current"])
    assert table.columns["header.stamp_ns"][1] == 5_002_000_000 and table.units["header.stamp_ns"] == "ns"


@pytest.mark.parametrize("name", FORMATS)
def test_a_cut_file_gives_a_table_or_one_line(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    written.WRITERS[name](path)
    data = path.read_bytes()
    for length in {1, 7, 130, len(data) // 3, len(data) // 2, len(data) - 40, len(data) - 1}:
        path.write_bytes(data[:length])
        _table_or_one_line(path)


@pytest.mark.parametrize("name", FORMATS)
def test_a_damaged_file_gives_a_table_or_one_line(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    written.WRITERS[name](path)
    data = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    random = np.random.default_rng(3)
    for _ in range(25):
        damaged = data.copy()
        places = random.integers(0, len(data), 8)
        damaged[places] = random.integers(0, 256, 8)
        path.write_bytes(damaged.tobytes())
        _table_or_one_line(path)


@pytest.mark.parametrize(
    "suffix", ["csv", "mat", "parquet", "npz", "npy", "mcap", pytest.param("h5", marks=pytest.mark.slow)]
)
def test_garbage_gives_one_line(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"garbage.{suffix}"
    path.write_bytes(np.random.default_rng(1).bytes(5000))
    with pytest.raises(UserError, match=r"garbage") as refused:
        read_table_file(path)
    assert "\n" not in str(refused.value)


def _table_or_one_line(path: Path) -> None:
    try:
        assert read_table_file(path).tables
    except UserError as error:
        assert "\n" not in str(error) and path.name in str(error)


@pytest.mark.parametrize(
    ("name", "package"), [pytest.param("v73.mat", "h5py", marks=pytest.mark.slow), ("a.parquet", "pyarrow")]
)
def test_an_absent_package_is_named_with_the_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, package: str
) -> None:
    written.WRITERS[name](tmp_path / name)
    _take_away(monkeypatch, package)
    with pytest.raises(UserError, match=rf"needs the package {package}; `pip install"):
        read_table_file(tmp_path / name)


def test_without_rosbags_the_topic_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written.ros2_bag(tmp_path / "bag")
    _take_away(monkeypatch, "rosbags")
    with pytest.raises(UserError, match=r"/joint_states.*pip install"):
        read_table_file(tmp_path / "bag")


def _take_away(monkeypatch: pytest.MonkeyPatch, package: str) -> None:
    real = importlib.import_module

    def without(name: str, *rest: object) -> object:
        if name.split(".", maxsplit=1)[0] == package:
            raise ImportError(name)
        return real(name)

    monkeypatch.setattr(importlib, "import_module", without)


@pytest.mark.parametrize(
    ("name", "says"),
    [("a.xlsx", "save the sheet as CSV"), ("a.db3", "ros2 bag convert"), ("a.mp4", "stillarm track")],
)
def test_what_is_no_table_says_what_to_do(tmp_path: Path, name: str, says: str) -> None:
    (tmp_path / name).write_bytes(b"anything")
    with pytest.raises(UserError, match=says):
        read_table_file(tmp_path / name)


def test_an_empty_file_and_an_absent_one_are_named(tmp_path: Path) -> None:
    (tmp_path / "empty.csv").write_bytes(b"")
    with pytest.raises(UserError, match="empty"):
        read_table_file(tmp_path / "empty.csv")
    with pytest.raises(UserError, match="cannot be read"):
        read_table_file(tmp_path / "absent.csv")
    with pytest.raises(UserError, match=r"folder without \.mcap"):
        read_table_file(tmp_path)
    (tmp_path / "fast.csv").write_text("time_s\n0\n")
    with pytest.raises(UserError, match="a CSV bundle; import it without --look"):
        read_table_file(tmp_path)
