"""Writes the long tables of a replay: one row for each frame and method, and one for each cycle and method."""

import csv
from math import isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np

from stillarm.controller.estimation.estimate import Status
from stillarm.controller.replay.replay import LiveComparison, MethodRun

FRAME_COLUMNS = ("frame", "received_s", "method", "status", "delay_s", "delay_std_s")
ESTIMATE_COLUMNS = ("time_s", "method", "status", "deflection_m", "deflection_std_m")
TRUST_COLUMNS = ("time_s", "method", "trust", "reason")


def write_tables(runs: list[MethodRun], directory: Path) -> None:
    """Write frames.csv, estimates.csv, and trust.csv, which has a row for each change of a method's trust.

    A missing number is an empty field.
    """
    with (directory / "frames.csv").open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(FRAME_COLUMNS)
        for run in runs:
            for frame, received_s, delay in run.frames:
                table.writerow(
                    (frame, received_s, run.method, delay.status, _field(delay.delay_s), _field(delay.std_s))
                )
    with (directory / "estimates.csv").open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(ESTIMATE_COLUMNS)
        for run in runs:
            for time_s, estimate in zip(run.times_s, run.estimates, strict=True):
                table.writerow(
                    (
                        time_s,
                        run.method,
                        estimate.status,
                        _field(estimate.deflection_m),
                        _field(estimate.deflection_std_m),
                    )
                )

    with (directory / "trust.csv").open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(TRUST_COLUMNS)
        for run in runs:
            trust = None
            for time_s, estimate in zip(run.times_s, run.estimates, strict=True):
                if estimate.trusted is not trust:
                    trust = estimate.trusted
                    table.writerow((time_s, run.method, trust, estimate.reason))


def replay_summary(
    recording: str, runs: list[MethodRun], comparison: LiveComparison | None
) -> dict[str, Any]:
    """The results of a replay, as plain values for summary.json."""
    return {
        "recording": recording,
        "live": None
        if comparison is None
        else {
            "cycles": comparison.cycles,
            "identical": comparison.identical,
            "cycles_different": comparison.different,
            "first_difference": comparison.first_difference,
        },
        "methods": {run.method: _method_summary(run) for run in runs},
    }


def _method_summary(run: MethodRun) -> dict[str, Any]:
    known = [delay for _, _, delay in run.frames if delay.status is Status.ESTIMATED]
    delays = np.array([d.delay_s for d in known]) if known else np.array([nan])
    deflections = np.array([e.deflection_m for e in run.estimates if e.status is Status.ESTIMATED])
    return {
        "cycles": len(run.estimates),
        "frames": len(run.frames),
        "frames_with_estimated_delay": len(known),
        "delay_mean_s": _number(float(np.mean(delays))),
        "delay_std_s": _number(float(np.std(delays))),
        "delay_stated_std_s": _number(float(np.mean([d.std_s for d in known]))) if known else None,
        "deflection_rms_m": _number(float(np.sqrt(np.mean(deflections**2)))) if len(deflections) else None,
    }


def _field(value: float) -> float | str:
    return value if isfinite(value) else ""


def _number(value: float) -> float | None:
    return value if isfinite(value) else None
