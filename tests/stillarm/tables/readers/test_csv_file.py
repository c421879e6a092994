"""Text tables: every dialect gives the same numbers; what is left out is said."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.user_error import UserError
from stillarm.tables.readers.csv_file import read
from stillarm.tables.readers.read_file import read_table_file
from stillarm.tables.table import as_floats
from tests.stillarm.tables import written

DIALECTS = [(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), ("|", "."), ("|", ",")]


@pytest.mark.parametrize(("separator", "decimal"), DIALECTS)
@pytest.mark.parametrize("header", [True, False])
def test_every_dialect_gives_the_same_numbers(
    tmp_path: Path, separator: str, decimal: str, header: bool
) -> None:
    path = tmp_path / "a.csv"
    path.write_text(written.text(separator, decimal, header))
    (table,) = read(path).tables
    assert list(table.columns) == (list(written.NAMES) if header else ["column 1", "column 2", "column 3"])
    for values, expected in zip(table.columns.values(), written.numbers().values(), strict=True):
        np.testing.assert_array_equal(as_floats(values), expected)


@pytest.mark.slow
@given(
    rows=st.lists(
        st.lists(st.floats(-1e6, 1e6, allow_nan=False, width=32), min_size=3, max_size=3),
        min_size=5,
        max_size=30,
    ),
    dialect=st.sampled_from(DIALECTS),
    header=st.booleans(),
    ends=st.sampled_from(["\n", "\r\n"]),
    mark=st.booleans(),
    trailing=st.booleans(),
    quoted=st.booleans(),
    encoding=st.sampled_from(["utf-8", "utf-16"]),
)
@settings(max_examples=150, deadline=None)
def test_any_numbers_in_any_dialect(
    tmp_path_factory: pytest.TempPathFactory,
    rows: list[list[float]],
    dialect: tuple[str, str],
    header: bool,
    ends: str,
    mark: bool,
    trailing: bool,
    quoted: bool,
    encoding: str,
) -> None:
    separator, decimal = dialect
    lines = [separator.join(["t [s]", "angle [deg]", "i"])] if header else []
    for row in rows:
        fields = [f"{value:.9f}".replace(".", decimal) for value in row]
        fields = [f'"{field}"' for field in fields] if quoted else fields
        lines.append(separator.join(fields) + (separator if trailing else ""))
    text = ("\ufeff" if mark and encoding == "utf-8" else "") + ends.join(lines) + ends
    path = tmp_path_factory.mktemp("dialect") / "a.csv"
    path.write_bytes(text.encode(encoding))
    (table,) = read(path).tables
    found = np.stack([as_floats(values) for values in table.columns.values()], axis=1)
    np.testing.assert_array_equal(found, np.array([[float(f"{value:.9f}") for value in row] for row in rows]))


def table_of(
    tmp_path: Path, text: str, name: str = "a.csv"
) -> tuple[dict[str, list[float]], tuple[str, ...], dict[str, str]]:
    path = tmp_path / name
    path.write_bytes(text.encode())
    file = read(path)
    (table,) = file.tables
    return {n: as_floats(v).tolist() for n, v in table.columns.items()}, file.notes, table.units


def test_excel_with_its_separator_line_and_decimal_commas(tmp_path: Path) -> None:
    text = "\ufeffsep=;\r\nZeit;Winkel\r\n0,0;1,5\r\n0,1;-2,25\r\n0,2;1.234,5\r\n"
    columns, _, _ = table_of(tmp_path, text)
    assert columns == {"Zeit": [0.0, 0.1, 0.2], "Winkel": [1.5, -2.25, 1234.5]}


def test_blanks_separate_whatever_their_number(tmp_path: Path) -> None:
    columns, _, _ = table_of(tmp_path, "  1.0   2.0 \r\n 3.0\t4.0\r\n5 6\r\n", "a.dat")
    assert columns == {"column 1": [1.0, 3.0, 5.0], "column 2": [2.0, 4.0, 6.0]}


def test_a_second_header_line_states_units(tmp_path: Path) -> None:
    _, _, units = table_of(tmp_path, "t,theta,i\n[s],[deg],[A]\n0,1,2\n1,2,3\n2,3,4\n")
    assert units == {"t": "s", "theta": "deg", "i": "A"}


def test_a_header_in_a_comment_counts(tmp_path: Path) -> None:
    columns, _, _ = table_of(tmp_path, "# made by hand\n# t, u\n0,1\n1,2\n2,3\n")
    assert list(columns) == ["t", "u"]


def test_lines_before_the_table_are_noted(tmp_path: Path) -> None:
    columns, notes, _ = table_of(
        tmp_path, "1428589683735\n3.97\n1, 2, [3.5, 4.5]\n5, 6, [7.5, 8.5]\n9, 10, [11, 12]\n"
    )
    assert columns["column 3"] == [3.5, 7.5, 11.0] and len(columns) == 4
    assert any("1428589683735" in note for note in notes)


def test_a_row_cut_short_is_left_out_and_said(tmp_path: Path) -> None:
    columns, notes, _ = table_of(tmp_path, "a,b\n" + "1,2\n" * 20 + "3")
    assert len(columns["a"]) == 20 and any("line 22 has 1 fields" in note for note in notes)


def test_a_word_among_numbers_is_no_measurement_and_said(tmp_path: Path) -> None:
    columns, notes, _ = table_of(tmp_path, "a,b\n" + "1,2\n" * 100 + "x,3\n")
    assert np.isnan(columns["a"][-1]) and any("line 102: 'x' is no number" in note for note in notes)


def test_a_text_column_is_left_out_and_said(tmp_path: Path) -> None:
    columns, notes, _ = table_of(tmp_path, "a,b,c\n" + "".join(f"{i},w{i}x,{i}\n" for i in range(9)))
    assert list(columns) == ["a", "c"] and any(note.startswith("b: no column of numbers") for note in notes)


def test_dates_become_nanoseconds(tmp_path: Path) -> None:
    columns, _, _ = table_of(
        tmp_path, "when,x\n" + "".join(f"2024-05-01 12:00:0{i}.5,{i}\n" for i in range(5))
    )
    assert np.diff(columns["when"]).tolist() == [1e9] * 4


def test_true_and_false_become_numbers(tmp_path: Path) -> None:
    columns, _, _ = table_of(tmp_path, "on,x\ntrue,1\nfalse,2\ntrue,3\n")
    assert columns["on"] == [1.0, 0.0, 1.0]


def test_prose_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("This is no table.\nNot at all.\n")
    with pytest.raises(UserError, match="no row of numbers"):
        read_table_file(tmp_path / "a.txt")


def test_rows_of_many_widths_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("".join(",".join(["1.5"] * (1 + i % 4)) + "\n" for i in range(40)))
    with pytest.raises(UserError, match="a table of one width is needed"):
        read_table_file(tmp_path / "a.csv")
