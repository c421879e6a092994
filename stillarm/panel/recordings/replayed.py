"""Turns the tables of `stillarm replay` into one column file for each method: `python -m ... DIR`, a process of its
own.

estimates.csv (time_s, method, status, deflection_m, deflection_std_m) and frames.csv (received_s, method, delay_s,
delay_std_s) become replay_METHOD.npy: time_s, deflection_m, deflection_std_m, delay_s, delay_std_s, where the delay is
the newest image's.
"""

import csv
import json
import sys
from pathlib import Path

import numpy as np

from stillarm.common.process.stop_signal import StopSignal

REPLAY_COLUMNS = ("deflection_m", "deflection_std_m", "delay_s", "delay_std_s")


def _by_method(path: Path, names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """(columns, rows) for each method; an empty field is NaN."""
    rows: dict[str, list[list[float]]] = {}
    with path.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            rows.setdefault(row["method"], []).append([float(row[name] or "nan") for name in names])
    return {method: np.array(values).T for method, values in rows.items()}


def convert(folder: Path) -> list[str]:
    """Write the files beside the tables; returns the methods."""
    estimates = _by_method(folder / "estimates.csv", ("time_s", "deflection_m", "deflection_std_m"))
    delays = _by_method(folder / "frames.csv", ("received_s", "delay_s", "delay_std_s"))
    for method, columns in estimates.items():
        delay = np.full((2, columns.shape[1]), np.nan)
        if method in delays:
            newest = np.searchsorted(delays[method][0], columns[0], side="right") - 1
            delay[:, newest >= 0] = delays[method][1:, newest[newest >= 0]]
        np.save(folder / f"replay_{method}.npy", np.vstack([columns, delay]))
    methods = sorted(estimates)
    (folder / "methods.json").write_text(json.dumps(methods))
    return methods


if __name__ == "__main__":
    StopSignal()
    convert(Path(sys.argv[1]))
