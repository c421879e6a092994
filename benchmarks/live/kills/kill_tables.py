"""Tables of killed supervisors for people: each gap over all runs, then what is asked."""

from typing import Any

import numpy as np

from stillarm.benchmarks.live.kills.kill_scoring import SETTLED_WITHIN_S
from stillarm.benchmarks.live.tables import number

Row = dict[str, Any]
_HONEST = 3.0  # normalised error squared
_LONGEST_BEYOND_S = 0.5


def by_gap(rows: list[Row]) -> list[Row]:
    """One row a method and gap asked: medians, and the worst kill."""
    table = []
    for method in dict.fromkeys(row["method"] for row in rows):
        for gap_s in sorted({row["gap_asked_s"] for row in rows}):
            these = [row for row in rows if row["method"] == method and row["gap_asked_s"] == gap_s]
            gaps = [row["gap_s"] for row in these]
            table.append(
                {
                    "method": method,
                    "gap asked, s": gap_s,
                    "gap, s": f"{min(gaps):.2f} to {max(gaps):.2f}",
                    "kills": len(these),
                    "amplitude, mm": _median(these, "amplitude_m", 1, 1e3),
                    "settled, s": _median(these, "settled_s", 2),
                    "worst": _worst(these, "settled_s", 2),
                    f"within {SETTLED_WITHIN_S:g} s": sum(map(settled_in_time, these)),
                    "error, %": _median(these, "error_mean", 2, 100.0),
                    "worst kill": _worst(these, "error_mean", 2, 100.0),
                    "max, %": _worst(these, "error_max", 1, 100.0),
                    "nes delay": _worst(these, "delay_normalised_error_squared_max", 1),
                    "nes deflection": _worst(these, "deflection_normalised_error_squared_max", 1),
                    "> 2 std, s": _worst(these, "longest_beyond_2_std_s", 2),
                }
            )
    return table


def settled_in_time(row: Row) -> bool:
    """Whether the error was below 2 % for good a second after the first new image."""
    return row["settled_s"] is not None and row["settled_s"] <= SETTLED_WITHIN_S


def verdict(rows: list[Row], method: str = "fused") -> list[Row]:
    """What is asked of the method that damps; after how many kills it was kept."""
    judged = [row for row in rows if row["method"] == method]
    asked = [
        (f"settled {SETTLED_WITHIN_S:g} s after the first new image", settled_in_time),
        (
            f"normalised error squared of the deflection at most {_HONEST:g}",
            lambda row: (row["deflection_normalised_error_squared_max"] or 0.0) <= _HONEST,
        ),
        (
            f"from the kill on no error beyond twice what {method} states for over {_LONGEST_BEYOND_S} s",
            lambda row: (row["longest_beyond_2_std_s"] or 0.0) <= _LONGEST_BEYOND_S,
        ),
    ]
    return [
        {"asked": text, "kept after": f"{sum(map(keeps, judged))} of {len(judged)} kills"}
        for text, keeps in asked
    ]


def _values(rows: list[Row], key: str) -> list[float]:
    return [row[key] for row in rows if row[key] is not None]


def _median(rows: list[Row], key: str, digits: int, unit: float = 1.0) -> str:
    values = _values(rows, key)
    return number(unit * float(np.median(values)) if values else None, digits)


def _worst(rows: list[Row], key: str, digits: int, unit: float = 1.0) -> str:
    values = _values(rows, key)
    return number(unit * max(values) if values else None, digits)
