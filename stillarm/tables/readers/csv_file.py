"""CSV and other text: any separator, decimal commas, a header or none, Excel's byte order mark and `sep=` line.

Lines before the first row of numbers are a preamble: the last of them that is as wide as the data names the columns,
and a second one of that width states their units.
"""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from stillarm.common.user_error import UserError
from stillarm.tables.readers.csv_dialect import NO_MEASUREMENT, Dialect, joined_quotes, sniffed
from stillarm.tables.table import Table, TableFile, Values

_COMMENTS = ("#", "%", "//")
_BAD_ROWS = 0.02  # of the rows: more than these of another width, and the file is no table
_BAD_FIELDS = 0.02  # of a column's fields: more that are no numbers, and the column is text
_INSTANT = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d([.,]\d+)?)?(Z|[+-]00:?00)?")
Line = tuple[int, str]


def read(path: Path) -> TableFile:
    """Read a text file. Raises UserError for one that holds no table of numbers."""
    text = _decoded(path.read_bytes(), path)
    separator, text = _stated_separator(text)
    lines = [(number, line) for number, line in joined_quotes(text) if line.strip()]
    body = [(number, line) for number, line in lines if not line.lstrip().startswith(_COMMENTS)]
    if not body:
        raise UserError(f"{path}: no rows; a table of numbers is needed")
    dialect = sniffed([line for _, line in body], separator)
    first = _first_row(body, dialect)
    if first is None:
        raise UserError(f"{path}: no row of numbers in {len(body)} lines; a table of numbers is needed")
    before = [line for line in lines if line[0] < body[first][0]]
    names, units, preamble = _header(before, dialect)
    notes = [f"line {number}, before the table: {line.strip()[:60]!r}" for number, line in preamble[:5]]
    rows, row_notes = _rows(body[first:], dialect, path)
    columns, column_notes = _columns(
        rows, names or [f"column {i + 1}" for i in range(dialect.width)], dialect
    )
    if not columns:
        raise UserError(f"{path}: no column of numbers in {len(rows)} rows")
    stated = {name: unit for name, unit in zip(names, units, strict=False) if unit and name in columns}
    notes += row_notes + column_notes
    return TableFile(path.name, "csv", (Table("", columns, stated),), tuple(notes))


def _decoded(data: bytes, path: Path) -> str:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return data.decode("utf-16", errors="replace")
    if data.count(b"\0") > len(data) // 100:
        raise UserError(
            f"{path}: not text, and none of the formats that are read: CSV, MAT, Parquet, NumPy, MCAP, HDF5"
        )
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")  # what Excel writes in the west


def _stated_separator(text: str) -> tuple[str | None, str]:
    """Excel's first line `sep=;`."""
    match = re.match(r'"?sep=(.)"?\r?\n', text, re.IGNORECASE)
    return (match[1], "\n" + text[match.end() :]) if match else (None, text)


def _first_row(body: list[Line], dialect: Dialect) -> int | None:
    """The first line that is a row of data: at its width, and numbers but for text columns that stay text."""
    width = dialect.width
    candidates = [i for i, (_, line) in enumerate(body) if len(dialect.fields(line)) == width]
    if not candidates:
        return None
    middle = dialect.fields(body[candidates[len(candidates) // 2]][1])
    numeric = [i for i, field in enumerate(middle) if dialect.number(field) is not None and field]
    for index in candidates:
        fields = dialect.fields(body[index][1])
        if numeric and all(dialect.number(fields[i]) is not None for i in numeric) and any(fields):
            return index
    return None


def _header(before: list[Line], dialect: Dialect) -> tuple[list[str], list[str], list[Line]]:
    """Names, units and the lines that are neither, of all lines before the data."""
    wide = []
    for number, line in before:
        text = line.strip()
        is_comment = text.startswith(_COMMENTS)
        fields = dialect.fields(text.lstrip("#%/ ") if is_comment else line)
        if len(fields) == dialect.width and not all(dialect.number(field) is not None for field in fields):
            wide.append((number, fields))
    if not wide:
        return [], [], before
    names, units = wide[-1], []
    if len(wide) > 1 and wide[-2][0] + 1 == wide[-1][0] and _are_units(wide[-1][1]):
        names, units = wide[-2], [field.strip("[]()") for field in wide[-1][1]]
    used = {names[0], wide[-1][0]} if units else {names[0]}
    return _distinct(names[1]), units, [line for line in before if line[0] not in used]


def _are_units(fields: list[str]) -> bool:
    """Whether a line looks like units: all short, and most in brackets or known as such."""
    known = {
        "s",
        "ms",
        "us",
        "ns",
        "m",
        "mm",
        "rad",
        "deg",
        "a",
        "ma",
        "v",
        "mv",
        "nm",
        "n",
        "g",
        "-",
        "",
        "hz",
        "px",
    }
    known |= {"rad/s", "deg/s", "m/s", "m/s2", "m/s^2", "n.m", "n*m", "%", "°", "k", "c", "°c"}
    return all(
        field.lower().strip("[]()") in known or (field[:1] in "[(" and field[-1:] in "])") for field in fields
    )


def _distinct(names: list[str]) -> list[str]:
    seen: dict[str, int] = {}
    found = []
    for index, given in enumerate(names):
        name = given or f"column {index + 1}"
        seen[name] = seen.get(name, 0) + 1
        found.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return found


def _rows(body: list[Line], dialect: Dialect, path: Path) -> tuple[list[tuple[int, list[str]]], list[str]]:
    rows = [(number, replace(dialect).fields(line)) for number, line in body]
    good = [row for row in rows if len(row[1]) == dialect.width]
    bad = [row for row in rows if len(row[1]) != dialect.width]
    if len(bad) > max(3, _BAD_ROWS * len(rows)):
        number, fields = bad[0]
        raise UserError(
            f"{path}: line {number}: {len(fields)} fields where most rows have {dialect.width}, and so in {len(bad)} "
            "lines; a table of one width is needed"
        )
    notes = [
        f"line {number} has {len(fields)} fields where the others have {dialect.width}; left out"
        for number, fields in bad[:3]
    ]
    return good, notes


def _columns(
    rows: list[tuple[int, list[str]]], names: list[str], dialect: Dialect
) -> tuple[dict[str, Values], list[str]]:
    columns: dict[str, Values] = {}
    notes: list[str] = []
    for place, name in enumerate(names):
        texts = [fields[place] for _, fields in rows]
        values, problem = _values(texts, [number for number, _ in rows], dialect)
        if values is None:
            notes.append(f"{name}: {problem}; left out")
            continue
        if problem:
            notes.append(f"{name}: {problem}")
        columns[name] = values
    return columns, notes


def _values(texts: list[str], lines: list[int], dialect: Dialect) -> tuple[Values | None, str]:
    """A column's numbers, int64 where all are whole; what was wrong with some of it."""
    whole = _whole(texts)
    if whole is not None:
        return whole, ""
    numbers = [dialect.number(text) for text in texts]
    bad = [i for i, number in enumerate(numbers) if number is None]
    if not bad:
        return _finite(np.array(numbers, dtype=np.float64))
    instants = _instants(texts)
    if instants is not None:
        return instants, ""
    first = f"line {lines[bad[0]]}: {texts[bad[0]][:30]!r} is no number"
    if len(bad) > max(1, _BAD_FIELDS * len(texts)):
        words = _two_words(texts)
        return (
            (words, "two words, taken as 0 and 1")
            if words is not None
            else (None, f"no column of numbers ({first})")
        )
    values = np.array([np.nan if number is None else number for number in numbers], dtype=np.float64)
    return values, f"{first}, and so in {len(bad)} rows; taken as no measurement"


def _finite(values: Values) -> tuple[Values, str]:
    infinite = np.isinf(values)
    if not infinite.any():
        return values, ""
    return np.where(
        infinite, np.nan, values
    ), f"{int(infinite.sum())} infinite values taken as no measurement"


def _whole(texts: list[str]) -> Values | None:
    try:
        return np.array([int(text) for text in texts], dtype=np.int64)
    except (ValueError, OverflowError):
        return None


def _instants(texts: list[str]) -> Values | None:
    """Dates with a time of day as ns since 1970; None where the column holds no such."""
    if not all(_INSTANT.fullmatch(text) for text in texts):
        return None
    plain = [re.sub(r"(Z|[+-]00:?00)$", "", text.replace(" ", "T").replace(",", ".")) for text in texts]
    return np.array(plain, dtype="datetime64[ns]").astype(np.int64)


def _two_words(texts: list[str]) -> Values | None:
    words = {text.lower() for text in texts}
    pairs = ({"true", "false"}, {"on", "off"}, {"yes", "no"})
    if not any(words - NO_MEASUREMENT <= pair for pair in pairs) or words <= NO_MEASUREMENT:
        return None
    return np.array([int(text.lower() in ("true", "on", "yes")) for text in texts], dtype=np.int64)
