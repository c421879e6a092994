"""The whole benchmark on a small scale: its columns, its determinism, a method that fails, its command."""

import json
from dataclasses import replace
from typing import Any

import pytest

from stillarm.benchmarks.estimators import trial as trial_module
from stillarm.benchmarks.estimators.conditions_table import (
    CLOSED_LOOP,
    CONDITIONS,
    OPEN_LOOP,
    ConditionJob,
    condition_rows,
    withstand,
)
from stillarm.benchmarks.estimators.damping_table import DampingJob, damp, damping_rows
from stillarm.benchmarks.estimators.run import Part, campaign, run
from stillarm.benchmarks.estimators.tables import Job
from stillarm.common.user_error import UserError
from stillarm.controller.estimation.methods import METHODS
from tests.fixtures.estimator_campaign import CONTRACT, SMALL


def without_times(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The rows less their microseconds."""
    return [{key: value for key, value in row.items() if not key.startswith("us_")} for row in rows]


def test_the_numbers_do_not_depend_on_the_number_of_workers() -> None:
    """One process or two, twice over: the same rows, with the contract's columns."""
    done: list[float] = []
    alone = run(SMALL, done.append, workers=1)
    together = run(SMALL, workers=2)
    assert without_times(alone["rows"]) == without_times(together["rows"])
    assert done == [0.25, 0.5, 0.75, 1.0]
    assert len(alone["rows"]) == 4
    for row in alone["rows"]:
        assert set(row) >= CONTRACT
        assert row["failure"] is None
        assert row["trials"] == 2
        assert row["ratio"] == pytest.approx(row["delay_rms_s"] / row["bound_s"])
        assert row["ratio"] > 0.9  # nobody beats the bound but by chance
        assert row["us_per_cycle"] > 0.0
    json.dumps(alone, allow_nan=False)


def test_a_method_that_raises_fails_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its row says so; the others' rows are complete."""
    usual = trial_module.run_method

    def run_method(name: str, *arguments: Any) -> Any:
        if name == "correlation":
            raise FloatingPointError("covariance lost")
        return usual(name, *arguments)

    monkeypatch.setattr("stillarm.benchmarks.estimators.tables.run_method", run_method)
    rows = {row["method"]: row for row in run(replace(SMALL, trials=1), workers=1)["rows"]}
    assert rows["correlation"]["failure"] == "FloatingPointError: covariance lost (1 trials)"
    assert rows["correlation"]["error_mean"] is None
    assert rows["correlation"]["trials"] == 0
    assert rows["timestamps"]["error_mean"] > 0.0


def test_the_campaign_holds_what_the_issue_asks_for() -> None:
    """Every method, ten regimes, three noises, at least twenty trials of 40 s by default; all conditions."""
    jobs = campaign(20, 0).jobs()
    cells = {(job.regime, job.noise) for job in jobs if isinstance(job, Job)}
    assert len(cells) == 30
    assert all(job.duration_s == 40.0 for job in jobs if isinstance(job, Job))
    assert sum(isinstance(job, Job) for job in jobs) == 30 * 20
    assert set(jobs[0].methods) == set(METHODS)
    assert {job.condition for job in jobs if hasattr(job, "condition")} == set(CONDITIONS)
    for trials, part, said in (
        (0, Part(), "--trials 0"),
        (1, Part(methods=["sorcery"]), "--methods sorcery"),
        (1, Part(tables=["fourth"]), "--tables fourth: unknown; use some of estimators,damping,conditions"),
        (1, Part(rows=["earthquake"]), "--rows earthquake: unknown"),
        (1, Part(regimes=["dead"]), "regime 'dead': unknown"),
    ):
        with pytest.raises(UserError, match=said):
            campaign(trials, 0, part)


def test_a_part_of_the_campaign_is_the_same_trials() -> None:
    """A trial keeps its seed in any part of the campaign; rows select the third table, regimes and noises the
    first.
    """
    whole = campaign(2, 5).jobs()
    for part, table, count in (
        (Part(["fused"], regimes=["live"]), Job, 3 * 2),
        (Part(["fused"], regimes=["live"], noises=[0.3]), Job, 2),
        (Part(["fused"], rows=["release"]), ConditionJob, 3 * 2),
        (Part(["fused"], rows=["release"], regimes=["live"]), ConditionJob, 2),
        (Part(["fused"], tables=["conditions"], rows=["as told"]), ConditionJob, 2 * 2),
    ):
        jobs = campaign(2, 5, part).jobs()
        assert len(jobs) == count
        for job in jobs:
            assert isinstance(job, table)
            assert replace(job, methods=tuple(METHODS)) in whole


def test_the_later_tables_have_a_row_for_each_method(monkeypatch: pytest.MonkeyPatch) -> None:
    """One short trial in closed loop, one condition in each kind of loop; a method nobody knows fails alone."""
    monkeypatch.setattr("stillarm.benchmarks.estimators.damping_table._DISTURBED_S", 16.0)
    monkeypatch.setattr("stillarm.benchmarks.estimators.damping_table._STRIKES_S", (8.0, 12.0))
    monkeypatch.setattr("stillarm.benchmarks.estimators.damping_table._RING_S", 16.0)
    monkeypatch.setitem(OPEN_LOOP, "as told", replace(OPEN_LOOP["as told"], duration_s=12.0))
    monkeypatch.setitem(CLOSED_LOOP, "damping on", replace(CLOSED_LOOP["damping on"], duration_s=12.0))
    methods = ("timestamps", "nobody's")
    rows = {row["method"]: row for row in damping_rows([damp(DampingJob("freerun drift", 0, 0, methods))])}
    assert rows["oracle"]["settling_over_oracle"] == rows["oracle"]["residual_over_oracle"] == 1.0
    assert rows["no damping"]["settling_time_s"] is None
    assert rows["no damping"]["residual_over_oracle"] > 2.0
    assert 0.9 < rows["timestamps"]["settling_over_oracle"] < 1.6
    assert rows["nobody's"]["failure"].startswith("UserError")
    done = [
        withstand(ConditionJob(name, "freerun drift", 0, 0, methods)) for name in ("as told", "damping on")
    ]
    by_row = {(row["condition"], row["method"]): row for row in condition_rows(done)}
    assert by_row["as told", "timestamps"]["error_mean"] > 0.02
    assert by_row["damping on", "timestamps"]["delay_rms_s"] > 0.001
    assert by_row["as told", "nobody's"]["trials"] == 0
    json.dumps(list(by_row.values()), allow_nan=False)
