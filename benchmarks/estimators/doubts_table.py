"""The fourth table: what the simpler methods say while `fused` says that it is starting, doubtful or settled.

A method that is replaced by a simpler one while it doubts itself must be worse than that one then. The simpler methods
run beside `fused` on the third table's starts and restarts; all are judged in the same cycles.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stillarm.benchmarks.estimators.conditions_table import NOISE, open_trial, seed_of
from stillarm.benchmarks.estimators.starts import OPEN_STARTS
from stillarm.benchmarks.estimators.trial import Answers, Mask, forced_cycles, run_method
from stillarm.benchmarks.estimators.world.generator import Data
from stillarm.benchmarks.estimators.world.regimes import REGIMES
from stillarm.controller.estimation.estimate import Trust

DOUBTER = "fused"
BEST = "best of the others, known afterwards"
_MOVES = 0.05  # of the nominal amplitude: below it, there is nothing to be right about
_FEWEST = 50  # cycles of a word that a trial needs to be judged


@dataclass(frozen=True)
class DoubtJob:
    """One trial of one start, for `fused` and all other methods."""

    condition: str
    regime: str
    trial: int
    seed: int
    methods: tuple[str, ...]


@dataclass(frozen=True)
class Told:
    """Sums over the cycles of one word in one trial: error as a fraction of the nominal amplitude, normalised error
    squared and its cycles, cycles without an answer, which count as a prediction of zero."""

    cycles: int
    error: float
    squared: float
    stated: int
    unanswered: int


@dataclass(frozen=True)
class Doubted:
    """What was told in a trial, by word and method."""

    job: DoubtJob
    told: dict[str, dict[str, Told]]


def doubt(job: DoubtJob) -> Doubted:
    """Run all methods on a trial, and judge each in the cycles in which `fused` said each word."""
    trial = open_trial(job.condition, REGIMES[job.regime], seed_of(job.seed, job.trial, job.condition))
    names = (DOUBTER, *(name for name in job.methods if name != DOUBTER))
    answers = {name: run_method(name, trial.data, trial.model, trial.scale) for name in names}
    data = trial.data
    moves = (data.amplitude_m > _MOVES * data.arm.amplitude_m) | forced_cycles(data)
    told: dict[str, dict[str, Told]] = {}
    for word in Trust:
        of_word: Mask = moves & (answers[DOUBTER].trust == word.value)
        if np.sum(of_word) >= _FEWEST:
            told[word.value] = {name: told_in(data, one, of_word) for name, one in answers.items()}
    return Doubted(job, told)


def told_in(data: Data, answers: Answers, cycles: Mask) -> Told:
    """What a method told in those cycles."""
    said: NDArray[np.float64] = answers.deflection_m[cycles]
    known = np.isfinite(said)
    error = np.where(known, said, 0.0) - data.deflection_m[cycles]
    std = np.where(known, answers.deflection_std_m[cycles], np.nan)
    stated = std > 0.0
    return Told(
        len(error),
        float(np.abs(error).sum()) / data.arm.amplitude_m,
        float(np.sum((error[stated] / std[stated]) ** 2)),
        int(stated.sum()),
        int((~known).sum()),
    )


def doubt_rows(doubted: Iterable[Doubted]) -> list[dict[str, Any]]:
    """A row for each word and method, over all trials. BEST: in each trial that of the others with the least error,
    which no rule can choose better."""
    trials = list(doubted)
    rows = []
    for word in Trust:
        told = [one.told[word.value] for one in trials if word.value in one.told]
        if not told:
            continue
        own = [one[DOUBTER] for one in told]
        by_name = {name: [one[name] for one in told] for name in told[0]}
        if len(by_name) > 1:
            by_name[BEST] = [
                min((one[name] for name in one if name != DOUBTER), key=lambda some: some.error)
                for one in told
            ]
        rows += [_row(word.value, name, some, own) for name, some in by_name.items()]
    return rows


def _row(word: str, name: str, told: list[Told], own: list[Told]) -> dict[str, Any]:
    cycles, stated = sum(one.cycles for one in told), sum(one.stated for one in told)
    squared = sum(one.squared for one in told) / stated if stated else float("nan")
    return {
        "trust": word,
        "method": name,
        "noise": NOISE,
        "error_mean": sum(one.error for one in told) / cycles,
        "deflection_normalised_error_squared": squared if isfinite(squared) else None,
        "unanswered": sum(one.unanswered for one in told) / cycles,
        "better_than_fused": sum(
            one.error < other.error for one, other in zip(told, own, strict=True)
        ) / len(told),
        "cycles": cycles,
        "trials": len(told),
    }  # fmt: skip


DOUBTED = tuple(OPEN_STARTS)
"""The conditions of the table."""
