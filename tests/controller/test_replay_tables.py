"""The tables of a replay hold the contract's columns, and exact numbers."""

import csv
from pathlib import Path

from controller.estimate import DelayEstimate, Estimate, Status
from controller.replay import LiveComparison, MethodRun
from controller.replay_tables import replay_summary, write_tables


def test_columns_and_values(tmp_path: Path) -> None:
    """Floats come back exactly; a number that is not there is an empty field."""
    known = Estimate(DelayEstimate(0.1 + 0.2, 1e-3, Status.ESTIMATED), 0.1, 0.0, 1e-17, Status.ESTIMATED)
    unknown = Estimate(DelayEstimate(0.074, 0.0064, Status.UNESTIMATED))
    run = MethodRun("correlation", [0.001, 0.002], [known, unknown], [(7, 0.002, known.delay)])
    write_tables([run], tmp_path)
    with (tmp_path / "frames.csv").open() as file:
        (frame,) = csv.DictReader(file)
    assert list(frame) == ["frame", "received_s", "method", "status", "delay_s", "delay_std_s"]
    assert float(frame["delay_s"]) == 0.1 + 0.2
    assert frame["status"] == "estimated"
    with (tmp_path / "estimates.csv").open() as file:
        first, second = csv.DictReader(file)
    assert list(first) == ["time_s", "method", "status", "deflection_m", "deflection_std_m"]
    assert float(first["deflection_std_m"]) == 1e-17
    assert second["deflection_m"] == "" and second["status"] == "unestimated"
    summary = replay_summary("rec", [run], LiveComparison(cycles=2))
    assert summary["methods"]["correlation"]["frames_with_estimated_delay"] == 1
    assert summary["live"]["identical"] is True
