"""The live benchmark's tables for people: every method over all runs, then every run."""

from collections.abc import Callable
from typing import Any

import numpy as np

Row = dict[str, Any]
# what is asked of the method that damps, and of the arm
_LONGEST_BEYOND_S, _ERROR_MEAN = 0.5, 0.01
_SETTLING_S, _SETTLING_BESIDE_OTHERS_S = 1.6, 2.5
_RIVAL = "correlation"


def by_method(rows: list[Row]) -> list[Row]:
    """One row a method: medians over the runs, and the worst run."""
    table = []
    for method in dict.fromkeys(row["method"] for row in rows):
        of_method = [row for row in rows if row["method"] == method]
        table.append(
            {
                "method": method,
                "error, %": _text(np.median, of_method, "error_mean", 2, 100.0),
                "worst run": _text(np.max, of_method, "error_mean", 2, 100.0),
                "max, %": _text(np.max, of_method, "error_max", 1, 100.0),
                "delay rms, ms": _text(np.median, of_method, "delay_rms_s", 2, 1e3),
                "nes delay": _text(np.max, of_method, "delay_normalised_error_squared_max", 1),
                "nes deflection": _text(np.max, of_method, "deflection_normalised_error_squared_max", 1),
                "> 2 std, s": _text(np.max, of_method, "longest_beyond_2_std_s", 2),
                "settled, s": _text(np.max, of_method, "settled_s", 2),
            }
        )
    return table


def by_run(rows: list[Row], method: str = "fused") -> list[Row]:
    """One row a run: what all its methods share, and what the one that damps made of it, where it was tried."""
    first = {row["run"]: row for row in reversed(rows)}
    of_method = {row["run"]: row for row in rows if row["method"] == method}
    return [
        {
            "run": run,
            "seed": row["seed"],
            f"{method}, %": _text(np.max, [of_method[run]] if of_method else [], "error_mean", 2, 100.0),
            "bound, %": _text(np.max, [row], "bound_mean", 2, 100.0),
            "> 2 std, s": _text(np.max, [of_method[run]] if of_method else [], "longest_beyond_2_std_s", 2),
            "settling, s": number(row["settling_time_damped_s"], 2),
            "frames": row["frames"],
            "lost": row["frames_lost"],
            "cycles": row["cycles"],
            "missed": row["deadline_misses"],
            "bare timer missed": row["floor_deadline_misses"],
            "own": row["own_deadline_misses"],
            "command max, rad/s": number(row["command_max_rad_s"], 3),
            "beyond limits": row["commands_beyond_limits"],
            "without grounds": row["commands_without_grounds"],
        }
        for run, row in sorted(first.items())
    ]


def verdict(rows: list[Row], load: int = 0, method: str = "fused") -> list[Row]:
    """What is asked of the method that damps, and of the commands; in how many runs it was kept.

    load: busy processes beside each run; without any the arm is to settle sooner.
    """
    settling_s = _SETTLING_BESIDE_OTHERS_S if load else _SETTLING_S
    rival = {row["run"]: row["error_mean"] for row in rows if row["method"] == _RIVAL}
    asked: list[tuple[str, Callable[[Row], bool]]] = [
        (
            f"mean error of {method} at most {100.0 * _ERROR_MEAN:g} %",
            lambda row: row["error_mean"] is not None and row["error_mean"] <= _ERROR_MEAN,
        ),
        (
            f"no error beyond twice what {method} states for over {_LONGEST_BEYOND_S} s",
            lambda row: (row["longest_beyond_2_std_s"] or 0.0) <= _LONGEST_BEYOND_S,
        ),
        (
            f"settled {settling_s} s after the strike",
            lambda row: (
                row["settling_time_damped_s"] is not None and row["settling_time_damped_s"] <= settling_s
            ),
        ),
        (
            "no command beyond its limits or without grounds",
            lambda row: not row["commands_beyond_limits"] + row["commands_without_grounds"],
        ),
        ("no frame lost", lambda row: row["frames_lost"] == 0),
        (
            "no deadline missed that the bare timer kept",
            lambda row: row["own_deadline_misses"] == 0,
        ),
    ]
    if any(row.get("bound_mean") is not None for row in rows):
        asked.insert(
            1,
            (
                "the same of the bound, which the accelerometer's noise leaves to anybody",
                lambda row: row["bound_mean"] is not None and row["bound_mean"] <= _ERROR_MEAN,
            ),
        )
    if rival:
        asked.append(
            (f"{method} better than {_RIVAL}", lambda row: _less(row["error_mean"], rival[row["run"]]))
        )
    judged = [row for row in rows if row["method"] == method]
    return [
        {"asked": text, "kept in": f"{sum(map(keeps, judged))} of {len(judged)} runs"}
        for text, keeps in asked
    ]


def _less(mine: float | None, others: float | None) -> bool:
    """Whether the error was smaller; one that could not be had counts as the larger."""
    return mine is not None and (others is None or mine < others)


def _text(
    how: Callable[[list[float]], float], rows: list[Row], key: str, digits: int, unit: float = 1.0
) -> str:
    values = [row[key] for row in rows if row.get(key) is not None]
    return number(unit * float(how(values)) if values else None, digits)


def number(value: float | None, digits: int) -> str:
    """With so many digits behind the point; a dash for none."""
    return "-" if value is None else f"{value:.{digits}f}"
