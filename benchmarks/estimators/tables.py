"""The first table: every method in every regime at every noise, compared with the bound and with each other."""

from collections.abc import Iterable
from dataclasses import dataclass, fields
from math import nan, pi, sqrt
from typing import Any

import numpy as np

from stillarm.benchmarks.estimators.bound import bound
from stillarm.benchmarks.estimators.trial import (
    Score,
    assumed_model,
    run_method,
    scale_error,
    score,
    scored_frames,
)
from stillarm.benchmarks.estimators.world.generator import generate
from stillarm.benchmarks.estimators.world.regimes import DURATION_S, REGIMES, Arm

Row = dict[str, Any]
_UNCERTAIN = (
    "error_mean", "error_max", "delay_rms_s", "ratio", "delay_normalised_error_squared",
    "deflection_normalised_error_squared",
)  # fmt: skip
_OURS = "fused"
_MEAN_OF_MODULUS = sqrt(2.0 / pi)  # of a Gaussian error, over its standard deviation


@dataclass(frozen=True)
class Job:
    """One trial of the first table, for all methods: the same data for each."""

    regime: str
    noise: float
    trial: int
    seed: int
    methods: tuple[str, ...]
    duration_s: float = DURATION_S


@dataclass(frozen=True)
class Judged:
    """Results of a job. scores: by method; failures: by method, what it raised.

    bound_s: rms over the scored frames of the posterior standard deviation of the delay; bound_mean_s: its mean;
    bound_deflection: mean absolute error at the bound, as a fraction of the momentary amplitude.
    """

    job: Job
    scores: dict[str, Score]
    failures: dict[str, str]
    bound_s: float
    bound_mean_s: float
    bound_deflection: float


def judge(job: Job) -> Judged:
    """Draw a trial, run every method on it, and compute its bound. If a method raises, the others continue."""
    regime, arm = REGIMES[job.regime], Arm()
    seed = job.seed, job.trial, list(REGIMES).index(job.regime)
    data, scale = generate(regime, job.noise, seed, job.duration_s, arm), 1.0 + scale_error(seed)
    scores, failures = {}, {}
    for name in job.methods:
        try:
            scores[name] = score(data, run_method(name, data, assumed_model(regime, job.noise), scale))
        except Exception as failure:  # an exception is the result of this method alone
            failures[name] = f"{type(failure).__name__}: {failure}"
    limit, frames = bound(data), scored_frames(data)
    std = limit.delay_std_s[frames]
    relative = limit.deflection_std_m[frames] / data.amplitude_m[data.frames.read_cycle[frames]]
    return Judged(
        job, scores, failures,
        _rms(std), float(std.mean()), _MEAN_OF_MODULUS * float(relative.mean()),
    )  # fmt: skip


def estimator_rows(judged: Iterable[Judged]) -> list[Row]:
    """A row for each method, regime and noise: means over the trials, and the rms for delay_rms_s and bound_s.

    ratio: delay_rms_s over bound_s, the smallest possible rms error. standard_errors: by figure, None if unknown.
    """
    rows = []
    for (regime, noise), cell in _cells(judged).items():
        for name in cell[0].job.methods:
            rows.append(
                {
                    "method": name,
                    "regime": regime,
                    "noise": noise,
                    **_figures(cell, name),
                    "standard_errors": _standard_errors(cell, name),
                    "trials": sum(name in one.scores for one in cell),
                    "failure": failure_of(one.failures.get(name) for one in cell),
                }
            )
    return rows


def _figures(cell: list[Judged], name: str) -> Row:
    row = mean_score([one.scores[name] for one in cell if name in one.scores])
    rms, bound_s = row["delay_rms_s"], _rms(one.bound_s for one in cell)
    return row | {
        "bound_s": bound_s,
        "ratio": None if rms is None else rms / bound_s,
        "bound_mean_s": _mean(one.bound_mean_s for one in cell),
        "bound_deflection": _mean(one.bound_deflection for one in cell),
    }


def _standard_errors(cell: list[Judged], name: str) -> dict[str, float | None]:
    """Standard errors over trials, by the jackknife (J. W. Tukey, Ann. Math. Statist. 29, 1958)."""
    without_one = (
        [_figures(cell[:k] + cell[k + 1 :], name) for k in range(len(cell))] if len(cell) > 1 else []
    )
    return {figure: _jackknife([row[figure] for row in without_one]) for figure in _UNCERTAIN}


def _jackknife(values: list[float | None]) -> float | None:
    known = [one for one in values if one is not None]
    complete = known and len(known) == len(values)
    return sqrt((len(known) - 1) * float(np.var(known))) if complete else None


def mean_score(scores: list[Score]) -> Row:
    """Means of the figures over trials, by their names in the table; None if no trial has the figure."""
    row: Row = {}
    for field in fields(Score):
        values = np.array([getattr(one, field.name) for one in scores])
        values = values[np.isfinite(values)]
        rms = field.name == "delay_rms_s"
        mean = nan if not len(values) else _rms(values) if rms else float(np.mean(values))
        row[_COLUMNS.get(field.name, field.name)] = mean if len(values) else None
    return row


_COLUMNS = {"us_mean": "us_per_cycle", "us_median": "us_per_cycle_median"}


def failure_of(failures: Iterable[str | None]) -> str | None:
    """The first failure with the number of trials that failed, or None."""
    failed = [text for text in failures if text is not None]
    return f"{failed[0]} ({len(failed)} trials)" if failed else None


def comparison_rows(judged: Iterable[Judged]) -> list[Row]:
    """Compare our method with each other one on the same trials.

    A row for each cell and figure. difference: mean of ours minus the other's; standard_error: of that mean over the
    paired trials; worse: whether it exceeds two standard errors. Empty if ours is not among the methods.
    """
    rows = []
    for (regime, noise), cell in _cells(judged).items():
        for other in cell[0].job.methods:
            pairs = [
                (one.scores[_OURS], one.scores[other]) for one in cell if {_OURS, other} <= set(one.scores)
            ]
            if other == _OURS or not pairs:
                continue
            for figure in ("error_mean", "error_max", "delay_rms_s"):
                differences = np.array([getattr(a, figure) - getattr(b, figure) for a, b in pairs])
                error = float(differences.std(ddof=1) / sqrt(len(pairs))) if len(pairs) > 1 else nan
                mean = float(differences.mean())
                rows.append(
                    {
                        "method": _OURS,
                        "other": other,
                        "regime": regime,
                        "noise": noise,
                        "figure": figure,
                        "difference": mean,
                        "standard_error": error if len(pairs) > 1 else None,
                        "worse": bool(mean > 2.0 * error),
                    }
                )
    return rows


def _cells(judged: Iterable[Judged]) -> dict[tuple[str, float], list[Judged]]:
    cells: dict[tuple[str, float], list[Judged]] = {}
    for one in judged:
        cells.setdefault((one.job.regime, one.job.noise), []).append(one)
    return cells


def _mean(values: Iterable[float]) -> float:
    return float(np.mean(list(values)))


def _rms(values: Iterable[float]) -> float:
    return float(np.sqrt(np.mean(np.square(list(values)))))
