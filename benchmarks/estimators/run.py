"""`stillarm benchmark estimators`: computes the three tables, with trials on all cores, and draws the pictures."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from stillarm.benchmarks.estimators.conditions_table import (
    CONDITIONS,
    ConditionJob,
    Withstood,
    condition_rows,
    regimes_of,
    withstand,
)
from stillarm.benchmarks.estimators.damping_table import (
    REGIMES_DAMPED,
    Damped,
    DampingJob,
    damp,
    damping_rows,
)
from stillarm.benchmarks.estimators.doubts_table import DOUBTED, Doubted, DoubtJob, doubt, doubt_rows
from stillarm.benchmarks.estimators.empty_cycle import empty_cycle_us
from stillarm.benchmarks.estimators.tables import Job, Judged, comparison_rows, estimator_rows, judge
from stillarm.benchmarks.estimators.world.regimes import DURATION_S, NOISES, REGIMES, regimes_named
from stillarm.common.user_error import UserError
from stillarm.controller.estimation.methods import all_methods

MOST_TRIALS_OF_LATER_TABLES = 10
QUICK_REGIMES = ("freerun constant", "freerun drift", "triggered jitter")
USUAL_TABLES = ("estimators", "damping", "conditions")
TABLES = (*USUAL_TABLES, "doubts")

AnyJob = Job | DampingJob | ConditionJob | DoubtJob
AnyResult = Judged | Damped | Withstood | Doubted
Progress = Callable[[float], None]


@dataclass(frozen=True)
class Campaign:
    """What to run. tables: some of TABLES; conditions: of the third and fourth table."""

    trials: int
    seed: int
    methods: tuple[str, ...]
    regimes: tuple[str, ...] = tuple(REGIMES)
    noises: tuple[float, ...] = NOISES
    duration_s: float = DURATION_S
    tables: tuple[str, ...] = USUAL_TABLES
    conditions: tuple[str, ...] = CONDITIONS

    def jobs(self) -> list[AnyJob]:
        """Every trial of every table, in a fixed order."""
        jobs: list[AnyJob] = []
        if "estimators" in self.tables:
            jobs += [
                Job(regime, noise, trial, self.seed, self.methods, self.duration_s)
                for regime in self.regimes
                for noise in self.noises
                for trial in range(self.trials)
            ]
        later = range(min(self.trials, MOST_TRIALS_OF_LATER_TABLES))
        if "damping" in self.tables:
            jobs += [
                DampingJob(regime, trial, self.seed, self.methods)
                for regime in REGIMES_DAMPED
                if regime in self.regimes
                for trial in later
            ]
        if "conditions" in self.tables:
            jobs += [
                ConditionJob(condition, regime, trial, self.seed, self.methods)
                for condition in self.conditions
                for regime in regimes_of(condition)
                if regime in self.regimes
                for trial in later
            ]
        if "doubts" in self.tables:
            jobs += [
                DoubtJob(condition, regime, trial, self.seed, self.methods)
                for condition in self.conditions
                if condition in DOUBTED
                for regime in regimes_of(condition)
                if regime in self.regimes
                for trial in later
            ]
        return jobs


@dataclass(frozen=True)
class Part:
    """A part of the benchmark; None: everything. rows: conditions of the third and fourth table."""

    methods: Sequence[str] | None = None
    regimes: Sequence[str] | None = None
    noises: Sequence[float] | None = None
    tables: Sequence[str] | None = None
    rows: Sequence[str] | None = None


def campaign(trials: int, seed: int, part: Part = Part(), quick: bool = False) -> Campaign:
    """The whole campaign or a part of it; `quick`: the first table's middle noise in three regimes, 12 s a trial.

    Rows select the third table; regimes or noises without tables select the first. Raises UserError for an unknown
    name or for no trials.
    """
    if trials < 1:
        raise UserError(f"--trials {trials}: at least 1")
    regimes = tuple(regime.name for regime in regimes_named(list(part.regimes) if part.regimes else None))
    for option, asked, known in (
        ("methods", part.methods, all_methods()),
        ("tables", part.tables, TABLES),
        ("rows", part.rows, CONDITIONS),
    ):
        for name in asked or ():
            if name not in known:
                raise UserError(f"--{option} {name}: unknown; use some of {','.join(known)}")
    tables = tuple(part.tables or USUAL_TABLES)
    if part.tables is None and (part.rows or part.regimes or part.noises):
        tables = ("conditions",) if part.rows else ("estimators",)
    methods, noises = tuple(part.methods or all_methods()), tuple(part.noises or NOISES)
    if not quick:
        return Campaign(
            trials, seed, methods, regimes, noises, DURATION_S, tables, tuple(part.rows or CONDITIONS)
        )
    chosen = regimes if part.regimes else QUICK_REGIMES
    return Campaign(trials, seed, methods, chosen, tuple(part.noises or (0.3,)), 12.0, ("estimators",))


def run(what: Campaign, progress: Progress = lambda done: None, workers: int | None = None) -> dict[str, Any]:
    """Run a campaign. Returns `rows` of the contract, with the tables `damping` and `conditions`, and `comparisons`.

    The results do not depend on `workers` (default: one per core), except the microseconds.
    """
    regimes_named(list(what.regimes))
    results = _run_all(what.jobs(), progress, workers or os.cpu_count() or 1)
    judged = [one for one in results if isinstance(one, Judged)]
    return {
        "rows": estimator_rows(judged),
        "damping": damping_rows(one for one in results if isinstance(one, Damped)),
        "conditions": condition_rows(one for one in results if isinstance(one, Withstood)),
        "doubts": doubt_rows(one for one in results if isinstance(one, Doubted)),
        "comparisons": comparison_rows(judged),
        "empty_cycle_us": empty_cycle_us(),
        "seed": what.seed,
        "trials": what.trials,
    }


def _run_all(jobs: list[AnyJob], progress: Progress, workers: int) -> list[AnyResult]:
    """The results in the order of the jobs. Processes are spawned: a fork would copy threads' locks."""
    results: dict[int, AnyResult] = {}
    if workers == 1:
        for index, job in enumerate(jobs):
            results[index] = run_job(job)
            progress((index + 1) / len(jobs))
    else:
        pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"))
        try:
            futures = {pool.submit(run_job, job): index for index, job in enumerate(jobs)}
            for done, future in enumerate(as_completed(futures), start=1):
                results[futures[future]] = future.result()
                progress(done / len(jobs))
        finally:
            pool.shutdown(cancel_futures=True)  # an interrupted campaign ends with the running trials
    return [results[index] for index in range(len(jobs))]


def run_job(job: AnyJob) -> AnyResult:
    """Run one trial of any table."""
    if isinstance(job, Job):
        return judge(job)
    if isinstance(job, DoubtJob):
        return doubt(job)
    return damp(job) if isinstance(job, DampingJob) else withstand(job)


def draw(result: dict[str, Any], what: Campaign, folder: Path) -> list[Path]:
    """Write the pictures into `folder`. Returns their paths."""
    from stillarm.benchmarks.estimators.figures import draw_errors_against_noise, draw_predictions

    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / "predictions.png"]
    draw_predictions(what.methods, what.seed, paths[0])
    for figure, limit, label in (
        ("error_mean", "bound_deflection", "mean prediction error / amplitude"),
        ("delay_rms_s", "bound_s", "rms delay error, s"),
    ):
        paths.append(folder / f"{figure}_against_noise.png")
        draw_errors_against_noise(result["rows"], figure, limit, label, paths[-1])
    return paths
