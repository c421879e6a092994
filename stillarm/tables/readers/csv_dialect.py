"""How a text file separates its fields and writes its decimals: tried out on its own lines, not assumed.

Every pair of separator and decimal mark splits a sample of lines. The right pair makes the most of them rows of
one width in which every field is a number.
"""

import csv
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

BLANKS = " "  # any run of blanks and tabs
_SEPARATORS = ("\t", ";", ",", "|", BLANKS)
_SAMPLE = 300
_SEVERAL = 0.9  # share of rows from which several columns are believed before one
NO_MEASUREMENT = frozenset({"", "nan", "na", "n/a", "null", "none", "-", "--", "#n/a", "nil"})
_LIST = re.compile(r"[\d\s.,;eE+\-\[\]()]+")
_UNWRAP = str.maketrans("[]()", "    ")


@dataclass(frozen=True)
class Dialect:
    """separator: of fields, BLANKS for any run of blanks. decimal: '.' or ','. width: fields in a row of data."""

    separator: str
    decimal: str
    width: int

    def fields(self, line: str) -> list[str]:
        """The fields of one line without its end; quotes are taken off, a separator at the end is dropped."""
        if "[" in line and _LIST.fullmatch(line):  # [x, y, z]: a list written into the row
            line = line.translate(_UNWRAP)
        if self.separator == BLANKS:
            return [field.strip('"') for field in line.split()]
        if '"' in line:
            found = next(csv.reader([line], delimiter=self.separator, skipinitialspace=True), [])
        else:
            found = line.split(self.separator)
        found = [field.strip() for field in found]
        while len(found) > max(1, self.width) and not found[-1]:
            found.pop()
        return found

    def number(self, text: str) -> float | None:
        """A field's number; NaN for no measurement, None where it is none."""
        if self.decimal == ",":
            if "." in text and "," not in text:
                return None
            text = text.replace(".", "").replace(",", ".")
        try:
            return None if "_" in text else float(text)
        except ValueError:
            return float("nan") if text.lower() in NO_MEASUREMENT else None


def sniffed(lines: list[str], separator: str | None = None) -> Dialect:
    """The dialect that makes the most of the lines rows of numbers; `separator` where the file states it."""
    sample = _spread(lines)
    judged: list[tuple[tuple[float, float, int], Dialect]] = []
    for mark in (separator,) if separator else _SEPARATORS:
        for decimal in ".,":
            if mark != decimal:
                width, share, whole = _judged(Dialect(mark, decimal, 0), sample)
                judged.append(((share, whole, width), Dialect(mark, decimal, width)))
    best_score, best = max(judged, key=lambda option: option[0])  # the first of equals
    if best.width == 1:
        # "1,2" is one number with a decimal comma or two numbers: two, unless a header has one name only.
        several = [
            (score, d)
            for score, d in judged
            if d.width > 1 and score[0] > _SEVERAL and _header_fits(d, lines)
        ]
        best = max(several, key=lambda option: option[0])[1] if several else best
    return best if best_score[0] > 0.0 else Dialect(",", ".", 1)


def _header_fits(dialect: Dialect, lines: list[str]) -> bool:
    """Whether the first line is a row of data, or as wide as one."""
    fields = dialect.fields(lines[0])
    return len(fields) == dialect.width or all(dialect.number(field) is not None for field in fields)


def _spread(lines: list[str]) -> list[str]:
    step = max(1, len(lines) // _SAMPLE)
    return lines[::step]


def _judged(dialect: Dialect, sample: list[str]) -> tuple[int, float, float]:
    """The commonest width of rows, the share of lines that are such rows, and of their fields that are numbers."""
    rows = [dialect.fields(line) for line in sample]
    for row in rows:
        while len(row) > 1 and not row[-1]:
            row.pop()
    numeric = [row for row in rows if any(_is_digit(field) for field in row)]
    widths = Counter(len(row) for row in numeric)
    if not widths:
        return 1, 0.0, 0.0
    width = max(widths, key=lambda w: (widths[w], w))
    chosen = [row for row in numeric if len(row) == width]
    good = sum(dialect.number(field) is not None for row in chosen for field in row)
    share = good / sum(len(row) for row in numeric)
    return width, round(share, 3), good / (width * len(chosen))


def _is_digit(field: str) -> bool:
    return any(character.isdigit() for character in field)


def joined_quotes(text: str) -> Iterator[tuple[int, str]]:
    """Lines with their numbers from 1; a quoted field that goes on over lines stays one line."""
    held, first = "", 0
    for number, line in enumerate(text.splitlines(), start=1):
        held, first = (f"{held} {line}", first) if held else (line, number)
        if held.count('"') % 2 == 0 or len(held) > 10_000:
            yield first, held
            held = ""
    if held:
        yield first, held
