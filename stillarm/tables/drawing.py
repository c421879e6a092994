"""Draws a file's columns as `--look` understands them: one strip for each column that moves."""

from pathlib import Path

import numpy as np

from stillarm.common.user_error import UserError, reason_of
from stillarm.tables.description import SECONDS
from stillarm.tables.guesses.column_look import ColumnLook, TableLook
from stillarm.tables.table import Table, TableFile, Values, as_floats

MOST_STRIPS = 24
_POINTS = 2000  # of a strip: beyond these each point is the lowest and highest of its stretch


def draw(file: TableFile, looks: tuple[TableLook, ...], path: Path) -> None:
    """Write a PNG. Raises UserError when it cannot be written."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    strips = [
        (table, look, column)
        for table, look in zip(file.tables, looks, strict=True)
        for column in look.columns
        if column.shape.kind in ("numbers", "flag") and column.quantity != "time"
    ]
    shown = strips[:MOST_STRIPS]
    figure = Figure(figsize=(11.0, max(2.0, 0.4 + 1.15 * len(shown))), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(max(1, len(shown)), 1, squeeze=False)[:, 0]
    for index, (axis, (table, look, column)) in enumerate(zip(axes, shown, strict=False)):
        time, label = _time(table, look)
        x, y = _thinned(time, as_floats(table.columns[column.name]))
        axis.plot(x, y, linewidth=0.7, color="#1f5f8b")
        axis.set_title(_title(column, look), loc="left", fontsize=8)
        last = index + 1 == len(shown) or shown[index + 1][0] is not table
        axis.set_xlabel(label if last else "", fontsize=7)
        axis.tick_params(labelsize=7, labelbottom=last)
        axis.margins(x=0.0)
    left_out = f"; {len(strips) - len(shown)} more columns" if len(strips) > len(shown) else ""
    figure.suptitle(f"{file.name}{left_out}", fontsize=9)
    try:
        figure.savefig(path, dpi=100)
    except OSError as error:
        raise UserError(f"{path}: cannot be written ({reason_of(error)}); name another with -o") from None


def _title(column: ColumnLook, look: TableLook) -> str:
    unit = f" [{column.unit}]" if column.unit else ""
    kind = f" {column.kind}" if column.kind else ""
    table = f"{look.name}: " if look.name else ""
    return f"{table}{column.name}: {column.quantity}{kind}{unit}, role {column.role}"


def _time(table: Table, look: TableLook) -> tuple[Values, str]:
    if look.clock is not None:
        values = table.columns[look.clock.column]
        since = values - look.clock.zero if look.clock.zero else values
        return as_floats(since) * SECONDS[look.clock.unit], "s"
    if look.sampling is not None and look.sampling.rate_hz:
        return np.arange(table.rows) / look.sampling.rate_hz, "s"
    return np.arange(table.rows, dtype=np.float64), "samples"


def _thinned(x: Values, y: Values) -> tuple[Values, Values]:
    """Lowest and highest value of each stretch, so that no peak is lost."""
    if len(x) <= 2 * _POINTS:
        return x, y
    length = len(x) // _POINTS
    count = len(x) // length
    blocks = y[: count * length].reshape(count, length)
    there = np.isfinite(blocks)
    ends = [np.where(there, blocks, np.inf).min(axis=1), np.where(there, blocks, -np.inf).max(axis=1)]
    pairs = np.stack(ends, axis=1).reshape(-1)
    return np.repeat(x[: count * length : length], 2), np.where(np.isfinite(pairs), pairs, np.nan)
