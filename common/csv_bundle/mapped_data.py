"""`stillarm import FILE --map input=COLUMN --map output=COLUMN --rate-hz HZ -o REC`: one input and one output."""

from math import isfinite, isnan
from pathlib import Path

import msgspec

from stillarm.common.csv_bundle.csv_table import CsvTable, floats, read_rows, read_text
from stillarm.common.recording.header import imported_header
from stillarm.common.recording.topics import PairSample
from stillarm.common.recording.writer import RecordingWriter
from stillarm.common.user_error import UserError

_ROLES = ("input", "output")


class MappedReport(msgspec.Struct, frozen=True):
    """What came in: rows, and how many inputs and outputs among them are no measurement."""

    rows: int
    input_absent: int
    output_absent: int


def import_mapped(
    path: str | Path, columns: dict[str, str], rate_hz: float, out_path: str | Path
) -> MappedReport:
    """Write the topic /pair: time_s = row / rate_hz, input and output in the file's own units.

    columns: {"input": COLUMN, "output": COLUMN}, each a name of the first row, or a number counted from 1. A
    first row of numbers is data. Fields are separated by ',', ';' or tabs; in a .dat or .txt file without
    these, by blanks. Raises UserError, one line.
    """
    path = Path(path)
    if sorted(columns) != sorted(_ROLES):
        mapped = ", ".join(sorted(columns)) or "none"
        raise UserError(f"{path}: --map {mapped}: exactly one input=COLUMN and one output=COLUMN are needed")
    if not (isfinite(rate_hz) and rate_hz > 0.0):
        raise UserError(f"{path}: --rate-hz {rate_hz}: a number above 0 is needed, samples per second")
    rows = _rows(path)
    names = [] if all(map(_is_number, rows[0][1])) else [field.strip() for field in rows.pop(0)[1]]
    if not rows:
        raise UserError(f"{path}: holds no data; rows of numbers are needed")
    places = {role: _place(path, columns[role], role, names, rows) for role in _ROLES}
    values = {role: _column(path, rows, place, columns[role]) for role, place in places.items()}
    notes = {
        "source": path.name,
        "input_column": columns["input"],
        "output_column": columns["output"],
        "rate_hz": repr(float(rate_hz)),
    }
    writer = RecordingWriter(out_path, imported_header("", notes))
    try:
        for index, (value, answer) in enumerate(zip(values["input"], values["output"], strict=True)):
            writer.write("/pair", PairSample(index / rate_hz, value, answer))
    finally:
        writer.close()
    absent = {role: sum(map(isnan, values[role])) for role in _ROLES}
    return MappedReport(rows=len(rows), input_absent=absent["input"], output_absent=absent["output"])


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    """The rows with their lines, one of them at least, and no separator at the end."""
    text = read_text(path)
    if path.suffix.lower() in (".dat", ".txt") and not any(mark in text for mark in ",;"):
        lines = enumerate(text.splitlines(), start=1)
        rows = [(n, line.split()) for n, line in lines if line.strip() and not line.lstrip().startswith("#")]
    else:
        rows = read_rows(path)
    while rows and all(row and not row[-1].strip() for _, row in rows):
        for _, row in rows:
            row.pop()
    if not rows:
        raise UserError(f"{path}: holds no data; rows of numbers are needed")
    return rows


def _place(path: Path, column: str, role: str, names: list[str], rows: list[tuple[int, list[str]]]) -> int:
    if column in names:
        return names.index(column)
    width = len(names) or len(rows[0][1])
    if column.isdecimal() and 1 <= int(column) <= width:
        return int(column) - 1
    known = f"{', '.join(names)}, or " if names else ""
    raise UserError(f"{path}: --map {role}={column}: no such column; use {known}a number from 1 to {width}")


def _column(path: Path, rows: list[tuple[int, list[str]]], place: int, name: str) -> list[float]:
    for line, row in rows:
        if len(row) <= place:
            raise UserError(
                f"{path}: line {line}: {len(row)} fields, but column {name} is number {place + 1}"
            )
    table = CsvTable(str(path), {name: [row[place].strip() for _, row in rows]}, [line for line, _ in rows])
    return floats(table, name)


def _is_number(text: str) -> bool:
    try:
        float(text or "nan")
    except ValueError:
        return False
    return True
