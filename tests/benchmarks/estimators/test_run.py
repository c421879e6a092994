"""The whole benchmark on a small scale: its columns, its determinism, a method that fails, its command."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
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
from stillarm.benchmarks.estimators.empty_cycle import empty_cycle_us
from stillarm.benchmarks.estimators.figures import draw_errors_against_noise
from stillarm.benchmarks.estimators.run import Campaign, Part, campaign, run
from stillarm.benchmarks.estimators.tables import Job, Judged, comparison_rows, estimator_rows, judge
from stillarm.benchmarks.estimators.trial import Score
from stillarm.benchmarks.estimators.world.generator import generate
from stillarm.benchmarks.estimators.world.regimes import REGIMES, Arm
from stillarm.common.user_error import UserError
from stillarm.controller.estimation.methods import METHODS
from stillarm.main import main

CONTRACT = {
    "method", "regime", "noise", "error_mean", "error_max", "pmcc", "delay_bias_s", "delay_rms_s", "bound_s", "ratio",
    "delay_normalised_error_squared", "deflection_normalised_error_squared", "us_per_cycle", "trials",
}  # fmt: skip
SMALL = Campaign(
    2,
    1,
    ("timestamps", "correlation"),
    ("freerun constant", "triggered jitter"),
    (0.3,),
    4.0,
    ("estimators",),
)


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


def made_up(ours: list[float], other: list[float]) -> list[Judged]:
    """Trials in which two methods had these mean errors."""

    def said(error: float) -> Score:
        return Score(error, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0)

    job = Job("freerun drift", 0.3, 0, 0, ("fused", "timestamps"))
    return [
        Judged(job, {"fused": said(a), "timestamps": said(b)}, {}, 1e-4, 1e-4, 1e-3)
        for a, b in zip(ours, other, strict=True)
    ]


def test_comparisons_are_paired() -> None:
    """What every trial shows counts, however much the trials differ; what they disagree on does not."""
    level = [0.01, 0.05, 0.2, 0.4]
    rows = comparison_rows(made_up([x + 0.001 * (1 + 0.1 * k) for k, x in enumerate(level)], level))
    worse = {row["figure"]: row["worse"] for row in rows}
    assert worse == {"error_mean": True, "error_max": False, "delay_rms_s": False}
    undecided = comparison_rows(made_up([0.02, 0.01, 0.03, 0.01], [0.01, 0.02, 0.01, 0.02]))
    assert not any(row["worse"] for row in undecided)
    assert comparison_rows(made_up([0.02], [0.01]))[0]["standard_error"] is None
    assert estimator_rows(made_up([0.02, 0.04], [0.01, 0.01]))[0]["error_mean"] == pytest.approx(0.03)


def test_standard_errors_are_those_of_means() -> None:
    """Of means the usual one; of the delay's ratio how far campaigns of as many trials differ from each other."""
    errors = [0.02, 0.05, 0.03, 0.02]
    row = estimator_rows(made_up(errors, errors))[0]
    assert row["standard_errors"]["error_mean"] == pytest.approx(np.std(errors, ddof=1) / 2.0)
    assert set(estimator_rows(made_up([0.02], [0.01]))[0]["standard_errors"].values()) == {None}
    random, trials = np.random.default_rng(5), made_up([0.01] * 20, [0.01] * 20)
    ratios, stated = [], []
    for _ in range(200):
        delays = 1e-4 * np.abs(random.standard_normal(20))
        cell = [
            replace(one, scores={"fused": replace(one.scores["fused"], delay_rms_s=float(delay))})
            for one, delay in zip(trials, delays, strict=True)
        ]
        row = estimator_rows(cell)[0]
        ratios.append(row["ratio"])
        stated.append(row["standard_errors"]["ratio"])
    assert np.mean(stated) == pytest.approx(np.std(ratios), rel=0.15)


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
    """Whatever is left out, a trial keeps its seed; rows ask for their table, regimes and noises for the first."""
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


def test_a_trial_of_old_keeps_its_seed() -> None:
    """New regimes and conditions come last: a place in the table is part of the seed of the trials."""
    assert list(REGIMES)[:9] == [
        f"{a} {b}" for a in ("freerun", "triggered", "stamped") for b in ("constant", "drift", "jitter")
    ]
    assert CONDITIONS[: len(OPEN_LOOP) + len(CLOSED_LOOP)] == (*OPEN_LOOP, *CLOSED_LOOP)
    assert (len(OPEN_LOOP), len(CLOSED_LOOP)) == (9, 2)


def test_conditions_do_to_the_data_what_they_say() -> None:
    """Frames go, the accelerometer dies or sticks, the payload lowers the frequency."""
    data = generate(
        REGIMES["freerun drift"], 0.3, (1,), 24.0, Arm(), OPEN_LOOP["payload at 20 s: frequency -10 %"].change
    )
    random = np.random.default_rng(1)
    lost = OPEN_LOOP["10 % of the frames lost"].change_data(data, random)
    assert len(lost.seen_m) / len(data.seen_m) == pytest.approx(0.9, abs=0.03)
    dead = OPEN_LOOP["accelerometer dead at 20 s"].change_data(data, random).acceleration_m_s2
    stuck = OPEN_LOOP["accelerometer stuck at 20 s"].change_data(data, random).acceleration_m_s2
    assert np.isnan(dead[20000:]).all()
    assert len(set(stuck[20000:].tolist())) == 1
    for changed in (dead, stuck):
        assert np.array_equal(changed[:20000], data.acceleration_m_s2[:20000])
    w = np.abs(data.motion.pole[data.motion.piece_at(np.array([19.9, 20.1]))])
    assert w[1] / w[0] == pytest.approx(0.9)


def test_the_later_tables_have_a_row_for_each_method(monkeypatch: pytest.MonkeyPatch) -> None:
    """One short trial in closed loop, one condition in each kind of loop; a method nobody knows fails alone."""
    monkeypatch.setattr("stillarm.benchmarks.estimators.damping_table._DISTURBED_S", 16.0)
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


def test_an_empty_cycle_exchanges_its_datagrams() -> None:
    """Every one of them is taken; the cost is a positive number of microseconds."""
    cost = empty_cycle_us(200)
    assert 0.0 < cost["median"] <= 1e6
    assert cost["mean"] > 0.0


def test_the_error_picture_holds_every_method_and_the_bound(tmp_path: Path) -> None:
    """A point for each row that has a number; a method without numbers is left out."""
    rows = [judge(Job("freerun constant", noise, 0, 0, ("timestamps",), 3.0)) for noise in (0.1, 1.0)]
    table = estimator_rows(rows)
    draw_errors_against_noise(table, "delay_rms_s", "bound_s", "rms delay error, s", tmp_path / "a.png")
    draw_errors_against_noise(
        [*table, *({**row, "method": "mute", "delay_rms_s": None} for row in table)],
        "delay_rms_s", "bound_s", "rms delay error, s", tmp_path / "b.png",
    )  # fmt: skip
    assert (tmp_path / "a.png").stat().st_size > 5000
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_the_command_writes_table_file_and_pictures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """`stillarm benchmark estimators` from end to end, cut down; mistakes in one line."""
    short = replace(SMALL, trials=1, regimes=("freerun constant",), methods=("timestamps",))
    monkeypatch.setattr("stillarm.benchmarks.estimators.run.campaign", lambda *arguments: short)
    file, folder = tmp_path / "rows.json", tmp_path / "pictures"
    assert main(["benchmark", "estimators", "--trials", "1", "--json", str(file), "--out", str(folder)]) == 0
    printed = capsys.readouterr().out
    assert "timestamps" in printed
    assert "only exchanges the datagrams" in printed
    result = json.loads(file.read_text())
    assert set(result["rows"][0]) >= CONTRACT
    assert {path.name for path in folder.iterdir()} == {
        "predictions.png", "error_mean_against_noise.png", "delay_rms_s_against_noise.png",
    }  # fmt: skip
    assert main(["benchmark", "vision", "--quick"]) == 1
    assert "--quick: only for `benchmark estimators`" in capsys.readouterr().err
    assert main(["benchmark", "estimators", "--trials", "0"]) == 1
    assert "--trials 0: at least 1" in capsys.readouterr().err
