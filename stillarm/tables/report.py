"""What `--look` prints of a table: a line on its time, and a row for each column. Pure."""

from math import isnan

from stillarm.tables.guesses.column_look import ColumnLook, TableLook
from stillarm.tables.roles import UNKNOWN

_LONGEST_NAME = 40


def head_lines(look: TableLook) -> list[str]:
    """Name, size, time, rate and gaps of a table."""
    name = f"table {look.name!r}: " if look.name else ""
    lines = [f"{name}{look.rows} rows, {len(look.columns)} columns"]
    sampling = look.sampling
    if look.clock is not None and sampling is not None:
        lines.append(f"  time: {look.clock.column}, in {look.clock.unit} ({look.clock.why})")
    else:
        lines.append("  time: no column tells it; rows are counted")
    if sampling is None or sampling.rate_hz is None:
        lines.append(
            '  rate: unknown; give rate_hz in the description, or leave "unknown" to count in samples'
        )
    else:
        duration = look.rows / sampling.rate_hz
        lines.append(f"  rate: {sampling.rate_hz:.6g} Hz, {duration:.4g} s{_irregular(look)}")
    return lines + [f"  note: {note}" for note in look.notes]


def _irregular(look: TableLook) -> str:
    sampling = look.sampling
    if look.clock is None or sampling is None:
        return ""
    parts = []
    if sampling.rate_hz and sampling.jitter_s > 1e-3 / sampling.rate_hz:
        parts.append(f"steps vary by {sampling.jitter_s * 1e3:.3g} ms")
    if sampling.gaps:
        parts.append(f"{sampling.gaps} gaps, the longest {sampling.longest_gap_s:.4g} s")
    if sampling.repeats:
        parts.append(f"{sampling.repeats} times repeat")
    if sampling.backward:
        parts.append(f"{sampling.backward} steps back")
    return "; " + ", ".join(parts) if parts else ", no gaps"


def column_rows(look: TableLook) -> list[dict[str, str]]:
    """A row for each column, for a terminal."""
    return [
        {
            "column": column.name
            if len(column.name) <= _LONGEST_NAME
            else "..." + column.name[3 - _LONGEST_NAME :],
            "range": _range(column),
            "what": f"{column.quantity}{', ' + column.kind if column.kind else ''}",
            "unit": column.unit or UNKNOWN if column.quantity not in ("count", "flag", "constant") else "",
            "role": column.role,
            "why": "; ".join(column.why) or "nothing tells",
        }
        for column in look.columns
    ]


def _range(column: ColumnLook) -> str:
    shape = column.shape
    if isnan(shape.low):
        return "no values"
    absent = f", {100.0 * shape.absent:.2g} % absent" if shape.absent > 0.0 else ""
    if shape.kind == "constant":
        return f"{shape.low:.5g}{absent}"
    step = f" by {shape.step:.4g}" if shape.step is not None and shape.kind == "numbers" else ""
    return f"{shape.low:.4g} to {shape.high:.4g}{step}{absent}"
