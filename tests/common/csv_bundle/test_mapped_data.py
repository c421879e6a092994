"""One input, one output, out of files of any shape."""

from pathlib import Path

import pytest

from stillarm.common.csv_bundle.mapped_data import import_mapped
from stillarm.common.recording.reader import open_recording
from stillarm.common.user_error import UserError

SHARED = Path(__file__).parents[4] / "shared" / "data"
BY_NUMBER = {"input": "1", "output": "2"}

SHAPES = {
    "names.csv": ('"u","y",\n1,2,\n3,4,\n', {"input": "u", "output": "y"}),
    "swapped.csv": ("y,u\n2,1\n4,3\n", {"input": "u", "output": "y"}),
    "numbers.csv": ("time,u,y\n0,1,2\n1,3,4\n", {"input": "2", "output": "3"}),
    "headless.csv": ("1,2\n3,4\n", BY_NUMBER),
    "blanks.dat": ("  1.0\t  2.0\t\r\n  3.0\t  4.0\t\r\n", BY_NUMBER),
    "named_blanks.txt": ("# c\nu   y\n1   2\n3   4\n", {"input": "u", "output": "y"}),
    "commas.txt": ("1,2,9\n3,4,9\n", BY_NUMBER),
}


@pytest.mark.parametrize("name", SHAPES)
def test_shapes(tmp_path: Path, name: str) -> None:
    content, columns = SHAPES[name]
    (tmp_path / name).write_text(content, newline="")
    report = import_mapped(tmp_path / name, columns, 4.0, tmp_path / "a.mcap")
    assert report.rows == 2
    recording = open_recording(tmp_path / "a.mcap")
    pairs = [(p.time_s, p.input, p.output) for p in recording.messages("/pair")]
    assert pairs == [(0.0, 1.0, 2.0), (0.25, 3.0, 4.0)]
    assert recording.header.notes["rate_hz"] == "4.0"


@pytest.mark.parametrize(
    ("content", "columns", "rate_hz", "expected"),
    [
        ("u,y\n1,2\n", {"input": "v", "output": "y"}, 1.0, "input=v: no such column; use u, y, or a number"),
        ("1,2\n", {"input": "1", "output": "3"}, 1.0, "output=3: no such column; use a number from 1 to 2"),
        ("1,2\n", {"input": "0", "output": "1"}, 1.0, "input=0: no such column"),
        ("1,2\n", {"input": "1"}, 1.0, "--map input: exactly one"),
        ("1,2\n", BY_NUMBER, 0.0, "--rate-hz 0.0"),
        ("1,2\n", BY_NUMBER, float("nan"), "--rate-hz nan"),
        ("1,2\n3,x\n", BY_NUMBER, 1.0, "line 2, column 2: 'x'"),
        ("1,2\n3\n", BY_NUMBER, 1.0, "line 2: 1 fields, but column 2 is number 2"),
        ("", BY_NUMBER, 1.0, "holds no data"),
        ("u,y\n", BY_NUMBER, 1.0, "holds no data"),
    ],
)
def test_errors_are_one_line(
    tmp_path: Path, content: str, columns: dict[str, str], rate_hz: float, expected: str
) -> None:
    (tmp_path / "d.csv").write_text(content)
    with pytest.raises(UserError) as refused:
        import_mapped(tmp_path / "d.csv", columns, rate_hz, tmp_path / "a.mcap")
    assert expected in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.hardware_data
@pytest.mark.parametrize(
    ("name", "columns", "rows"),
    [
        ("silverbox/SNLS80mV.csv", {"input": "V1", "output": "V2"}, 131072),
        ("robot_arm/robot_arm.dat", BY_NUMBER, 1024),
    ],
)
def test_measured_data(tmp_path: Path, name: str, columns: dict[str, str], rows: int) -> None:
    if not (SHARED / name).exists():
        pytest.skip(f"measured data are not there: {name}")
    report = import_mapped(SHARED / name, columns, 1e7 / 2**14, tmp_path / "a.mcap")
    assert (report.rows, report.input_absent, report.output_absent) == (rows, 0, 0)
    assert open_recording(tmp_path / "a.mcap").counts["/pair"] == rows
