"""A replay's tables, read back: what each method said, as outside scripts would read it."""

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stillarm.benchmarks.live.scoring import Estimates


def read_estimates(directory: Path) -> dict[str, Estimates]:
    """The methods in `directory`/estimates.csv and frames.csv, by name; an empty field is NaN."""
    cycles = _by_method(directory / "estimates.csv", ("time_s", "deflection_m", "deflection_std_m"))
    frames = _by_method(directory / "frames.csv", ("frame", "received_s", "delay_s", "delay_std_s"))
    said = {}
    for method, (time_s, deflection, deflection_std) in cycles.items():
        frame, received, delay, delay_std = frames.get(method, np.empty((4, 0)))
        said[method] = Estimates(
            time_s, deflection, deflection_std, frame.astype(np.int64), received, delay, delay_std
        )
    return said


def _by_method(path: Path, columns: tuple[str, ...]) -> dict[str, NDArray[np.float64]]:
    found: dict[str, list[list[float]]] = {}
    with path.open(newline="") as file:
        rows = csv.reader(file)
        names = next(rows)
        method, places = names.index("method"), [names.index(column) for column in columns]
        for row in rows:
            found.setdefault(row[method], []).append([float(row[place] or "nan") for place in places])
    return {name: np.array(values).T for name, values in found.items()}
