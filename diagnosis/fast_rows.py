"""The rows of fast.csv put in order: rows that were written twice, or too early or late, and how often rows come.

A clock that was set is no disorder: its rows lie on places that other rows hold already, and stay as they are.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

REGULAR = 0.25  # of the usual step, by which a regular one may differ
_WHOLE = 2e-3  # of a cycle: a row step so near to whole cycles is one of the model's cycles
_MOSTLY = 0.9  # of the steps: stamps that scatter more are kept apart by the model's finer grid
_OTHER_RATE = 1.5  # times the model's cycle, or less than its half: rows come at another rate


def rows_in_order(time_s: Array, columns: dict[str, Array]) -> Rows:
    """Indices of the rows to use, in their order in time: without rows that repeat the one before them, value for
    value; sorted by time where that puts each at an instant of its own."""
    rows = np.arange(len(time_s))
    again = np.zeros(len(time_s), bool)
    again[1:] = np.diff(time_s) == 0.0
    if again.any():
        for values in columns.values():
            if values.dtype.kind == "f":
                same = (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
                again[1:] &= same
        rows = rows[~again]
    step = np.diff(time_s[rows])
    if np.all(step > 0.0) or not len(step):
        return rows
    ordered = rows[np.argsort(time_s[rows], kind="stable")]
    usual = float(np.median(np.abs(step)))
    return ordered if float(np.min(np.diff(time_s[ordered]))) > REGULAR * usual else rows


def row_step_s(time_s: Array, cycle_s: float) -> float:
    """Time between the places of the grid, s: the model's cycle, unless rows plainly come at another rate. The mean of
    the regular steps, as times are often rounded; a whole number of cycles where it is one but for that."""
    step = np.diff(time_s)
    step = step[step > 0.0]
    if not len(step):
        return cycle_s
    usual = float(np.median(step))
    if 1.0 / _OTHER_RATE**2 < usual / cycle_s < _OTHER_RATE:
        return cycle_s
    regular = np.abs(step - usual) < REGULAR * usual
    if regular.mean() < _MOSTLY:
        return cycle_s
    mean_s = float(np.mean(step[regular]))
    cycles = round(mean_s / cycle_s)
    return cycles * cycle_s if cycles and abs(mean_s / cycle_s - cycles) < _WHOLE * cycles else mean_s
