"""A CSV file as columns of texts, and the texts as numbers; errors name file, row, column and value.

Python's csv splits the fields. A table reader such as pandas' would not say which field is wrong and what is allowed.

Tolerated because it is harmless: byte order mark, CRLF, quotes, spaces around fields, blank lines, comment
lines that begin with '#', ';' or tab between fields, an empty column at the end of every row.
"""

import csv
import io
import re
from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite, isnan, nan
from pathlib import Path

from stillarm.common.user_error import UserError, reason_of

_NO_MEASUREMENT = frozenset({"", "nan", "na", "n/a", "null", "none"})


@dataclass(frozen=True)
class CsvTable:
    """Columns of one length, by name, in the file's order; `lines`: the line in the file of each row."""

    name: str
    columns: dict[str, list[str]]
    lines: list[int]

    def error(self, row: int, column: str, problem: str) -> UserError:
        """An error about one field; `problem` says what is allowed."""
        value = self.columns[column][row]
        shown = value if len(value) <= 40 else value[:37] + "..."
        return UserError(f"{self.name}: line {self.lines[row]}, column {column}: {shown!r}: {problem}")


def read_text(path: Path) -> str:
    """A text file in UTF-8, with or without byte order mark. Raises UserError."""
    try:
        return path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise UserError(f"{path}: cannot be read ({reason_of(error)}); name an existing file") from None
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: not UTF-8 text at byte {error.start}; save it as CSV in UTF-8") from None


def read_csv(path: Path) -> CsvTable:
    """Read a CSV file whose first row names the columns. Raises UserError."""
    rows = read_rows(path)
    if not rows:
        raise UserError(f"{path}: empty; its first row must name the columns")
    names = [field.strip() for field in rows[0][1]]
    body = rows[1:]
    while names and not names[-1]:  # a separator at the end of every row
        for line, row in body:
            if len(row) == len(names) and row[-1].strip():
                raise UserError(
                    f"{path}: line {line}: column {len(names)} holds {row[-1][:40]!r} but has no name"
                )
            del row[len(names) - 1 :]
        names.pop()
    for number, name in enumerate(names, start=1):
        if not name:
            raise UserError(f"{path}: line {rows[0][0]}: column {number} has no name; give it one")
        if names.index(name) != number - 1:
            raise UserError(f"{path}: line {rows[0][0]}: two columns are named {name}; rename or delete one")
    for line, row in body:
        if len(row) != len(names):
            raise UserError(
                f"{path}: line {line}: {len(row)} fields where the first row names {len(names)}; "
                "leave a field without a measurement empty, or delete the line"
            )
    fields = list(zip(*(row for _, row in body), strict=True)) if body else [()] * len(names)
    columns = {name: [field.strip() for field in fields[i]] for i, name in enumerate(names)}
    return CsvTable(str(path), columns, [line for line, _ in body])


def read_rows(path: Path) -> list[tuple[int, list[str]]]:
    """The rows that are neither blank nor comments, each with its line in the file. Raises UserError."""
    lines = _Lines(read_text(path))
    found: list[tuple[int, list[str]]] = []
    try:
        for row in csv.reader(lines, delimiter=lines.delimiter, skipinitialspace=True, strict=True):
            if row and (len(row) > 1 or row[0].strip()):
                found.append((lines.number, row))
    except csv.Error as error:
        raise UserError(f"{path}: line {lines.number}: not readable as CSV ({error})") from None
    return found


class _Lines:
    """The lines that are no comments, counted as they stand in the file."""

    def __init__(self, text: str) -> None:
        self._text = text
        self.number = 0
        first = next(iter(self), "")
        self.number = 0
        # With a ',' in the first row ';' is part of a field; without, it separates, as some spreadsheets
        # write it.
        self.delimiter = next((mark for mark in ",;\t" if mark in first), ",")

    def __iter__(self) -> Iterator[str]:
        quoted = False  # inside a quoted field that goes on over lines nothing is a comment
        for number, line in enumerate(io.StringIO(self._text, newline=""), start=1):
            self.number = number
            if quoted or (line.strip() and not line.lstrip().startswith("#")):
                quoted ^= line.count('"') % 2 == 1
                yield line


def floats(table: CsvTable, column: str) -> list[float]:
    """A column as numbers; NaN for an empty field. Raises UserError for what is no number, or not finite."""
    texts = table.columns[column]
    try:
        values = [float(text) if text else nan for text in texts]
        if all(map(isfinite, values)) and "_" not in "".join(texts):
            return values
    except ValueError:
        pass
    return [_float(table, column, row, text) for row, text in enumerate(texts)]


def _float(table: CsvTable, column: str, row: int, text: str) -> float:
    if text.lower() in _NO_MEASUREMENT:
        return nan
    try:
        value = float(text)
    except ValueError:
        value = nan
    if not isfinite(value) or "_" in text:
        hint = "a number with a decimal point" if "," in text else "a finite number"
        raise table.error(row, column, f"{hint} is needed, or an empty field for no measurement")
    return value


def integers(table: CsvTable, column: str, absent: int) -> list[int]:
    """A column as whole numbers (12.0 counts as one), `absent` for an empty field. Raises UserError."""
    found = []
    for row, text in enumerate(table.columns[column]):
        try:
            value = int(text) if text.lstrip("+-").isdecimal() else _float(table, column, row, text)
        except ValueError:  # thousands of digits
            value = 2.0**64
        if isnan(value):
            value = absent
        if value != int(value) or not -(2**63) <= value < 2**63:
            raise table.error(row, column, "a whole number of at most 63 bits is needed, or an empty field")
        found.append(int(value))
    return found


def booleans(table: CsvTable, column: str) -> list[bool]:
    """A column of 0/1 or true/false; an empty field is false. Raises UserError."""
    found = []
    for row, text in enumerate(table.columns[column]):
        if text.lower() not in _BOOLEANS:
            raise table.error(row, column, "0, 1, true or false is needed")
        found.append(_BOOLEANS[text.lower()])
    return found


_BOOLEANS = {"": False, "0": False, "0.0": False, "false": False, "1": True, "1.0": True, "true": True}


def numbers_or_texts(texts: list[str]) -> list[float | str | None]:
    """An unknown column: numbers if all fields are numbers, else texts; None for an empty field.

    Serial numbers ("007", more than 15 digits) stay texts: as floats they would come back as others.
    """
    try:
        values = [float(text) if text else None for text in texts]
        if all(value is None or isfinite(value) for value in values) and not any(map(_SERIAL.match, texts)):
            return list(values)
    except ValueError:
        pass
    return [text or None for text in texts]


_SERIAL = re.compile(r"[+-]?0\d|[+-]?\d{16}|.*_")
