"""The tables of a replay hold the contract's columns, and exact numbers."""

import csv
from pathlib import Path

from stillarm.controller.estimation.estimate import DelayEstimate, Estimate, Status, Trust
from stillarm.controller.replay.replay import LiveComparison, MethodRun
from stillarm.controller.replay.replay_tables import replay_summary, write_tables


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


def test_trust_has_a_row_where_it_changes_and_none_between(tmp_path: Path) -> None:
    """For each method from its first cycle on, with the reason at that time."""
    known = DelayEstimate(0.07, 1e-3, Status.ESTIMATED)

    def said(trust: Trust | None, reason: str = "") -> Estimate:
        return Estimate(known, 0.1, status=Status.ESTIMATED, reason=reason, trust=trust)

    course = [Trust.STARTING, Trust.STARTING, Trust.SETTLED, Trust.DOUBTFUL, Trust.DOUBTFUL, Trust.SETTLED]
    fused = [said(trust, "far off, it seems" if trust is Trust.DOUBTFUL else "") for trust in course]
    times = [0.001 * k for k in range(6)]
    other = MethodRun("correlation", times, [said(None)] * 6, [])
    write_tables([MethodRun("fused", times, fused, []), other], tmp_path)
    with (tmp_path / "trust.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["time_s", "method", "trust", "reason"]
    assert [(row["method"], row["trust"], float(row["time_s"])) for row in rows] == [
        ("fused", "starting", 0.0),
        ("fused", "settled", 0.002),
        ("fused", "doubtful", 0.003),
        ("fused", "settled", 0.005),
        ("correlation", "settled", 0.0),
    ]
    assert rows[2]["reason"] == "far off, it seems"


def test_a_method_that_does_not_check_itself_starts_until_its_delay_is_known() -> None:
    for status, trust in (
        (Status.UNESTIMATED, Trust.STARTING),
        (Status.ESTIMATED, Trust.SETTLED),
        (Status.HELD, Trust.SETTLED),
    ):
        assert Estimate(DelayEstimate(0.07, 0.001, status)).trusted is trust
    known = DelayEstimate(0.07, 0.001, Status.ESTIMATED)
    assert Estimate(known, trust=Trust.DOUBTFUL).trusted is Trust.DOUBTFUL
