"""Fewer points that show the same curve: the least and the greatest value of each interval. Pure."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def min_max(times_s: Floats, columns: Floats, intervals: int) -> tuple[Floats, Floats]:
    """At most two points for each of `intervals` intervals of equal numbers of rows, so that no peak is lost.

    times_s: (n,), s, ascending. columns: (c, n). intervals: at least 1. Returns times (m,) and columns (c, m), with
    m = n where n <= 2 * intervals, else 2 * intervals: in each interval and column the least and the greatest finite
    value, in the order in which they come, at the interval's first time and its middle one. An interval without a
    finite value is NaN.
    """
    rows = len(times_s)
    if rows <= 2 * intervals:
        return times_s, columns
    edges = np.linspace(0, rows, intervals + 1).astype(np.int64)
    starts = edges[:-1]
    missing = ~np.isfinite(columns)
    least = np.minimum.reduceat(np.where(missing, np.inf, columns), starts, axis=1)
    greatest = np.maximum.reduceat(np.where(missing, -np.inf, columns), starts, axis=1)
    empty = least > greatest
    least[empty] = greatest[empty] = np.nan
    rising = _least_first(columns, edges, least, greatest)
    thinned = np.empty((len(columns), 2 * intervals))
    thinned[:, 0::2] = np.where(rising, least, greatest)
    thinned[:, 1::2] = np.where(rising, greatest, least)
    times = np.empty(2 * intervals)
    times[0::2] = times_s[starts]
    times[1::2] = times_s[(edges[:-1] + edges[1:]) // 2]
    return times, thinned


def _least_first(
    columns: Floats, edges: NDArray[np.int64], least: Floats, greatest: Floats
) -> NDArray[np.bool_]:
    """Whether the least value of each interval comes before the greatest; shape (c, intervals)."""
    rows = columns.shape[1]
    place = np.arange(rows)
    counts = np.diff(edges)
    first_least = np.where(columns == np.repeat(least, counts, axis=1), place, rows)
    first_greatest = np.where(columns == np.repeat(greatest, counts, axis=1), place, rows)
    starts = edges[:-1]
    before: NDArray[np.bool_] = np.minimum.reduceat(first_least, starts, axis=1) <= np.minimum.reduceat(
        first_greatest, starts, axis=1
    )
    return before
