"""The third table: conditions that the methods do not know, losses, and motion."""

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, replace
from math import isfinite
from typing import Any

import numpy as np

from stillarm.benchmarks.estimators.closed_loop import Course, run_closed, to_and_fro
from stillarm.benchmarks.estimators.starts import (
    CLOSED_STARTS,
    FIGURES,
    OPEN_STARTS,
    REGIMES_STARTED,
    During,
    during_of,
)
from stillarm.benchmarks.estimators.tables import failure_of, mean_score
from stillarm.benchmarks.estimators.trial import (
    Said,
    Score,
    assumed_model,
    run_method,
    said_of,
    scale_error,
    score,
    score_of,
    within,
)
from stillarm.benchmarks.estimators.world.condition import Condition
from stillarm.benchmarks.estimators.world.generator import Change, Data, cycle_times, generate
from stillarm.benchmarks.estimators.world.regimes import (
    AFTER_IMPACT_S,
    CYCLE_S,
    DURATION_S,
    REGIMES,
    SETTLING_S,
    Arm,
    Regime,
)
from stillarm.common.files.model import Model

REGIMES_CHANGED = ("freerun drift", "triggered drift")
NOISE = 0.3
ONSET_S = 20.0
_STRIKE_EVERY_S = 2.7
_MOVE_EVERY_S, _MOVE_S, _MOVE_RAD_S = 4.0, 1.5, 0.1


def _lose_frames(data: Data, random: np.random.Generator) -> Data:
    return data.with_frames_lost(random.uniform(size=len(data.frames.number)) < 0.1)


def _die(data: Data, random: np.random.Generator) -> Data:
    acceleration = data.acceleration_m_s2.copy()
    acceleration[round(ONSET_S / CYCLE_S) :] = np.nan
    return replace(data, acceleration_m_s2=acceleration)


def _stick(data: Data, random: np.random.Generator) -> Data:
    acceleration = data.acceleration_m_s2.copy()
    acceleration[round(ONSET_S / CYCLE_S) :] = acceleration[round(ONSET_S / CYCLE_S)]
    return replace(data, acceleration_m_s2=acceleration)


def _drift_away(data: Data, random: np.random.Generator) -> Data:
    """The scene comes 20 % nearer within 20 s, from 10 s on."""
    nearer = 1.0 + 0.2 * np.clip((data.frames.exposed_s - 0.5 * ONSET_S) / ONSET_S, 0.0, 1.0)
    return replace(data, seen_m=data.seen_m * nearer)


OPEN_LOOP: dict[str, Condition] = {
    "as told": Condition(),
    "frequency 2 % off": Condition(Arm(frequency_hz=2.6 * 1.02)),
    "payload at 20 s: frequency -10 %": Condition(change=Change(ONSET_S, 0.9), from_s=ONSET_S),
    "scene 20 % off in depth": Condition(scale_factor=0.8),
    "scene 20 % nearer within 20 s": Condition(change_data=_drift_away),
    "10 % of the frames lost": Condition(change_data=_lose_frames),
    "accelerometer dead at 20 s": Condition(duration_s=80.0, from_s=ONSET_S, change_data=_die),
    "accelerometer stuck at 20 s": Condition(duration_s=80.0, from_s=ONSET_S, change_data=_stick),
    "vibration kept up by a force in step": Condition(
        Arm(damping_ratio=0.0, impact_every_s=(1e3, 2e3), impact_to=(1.0, 1.0))
    ),
}


_STRIKES = {0.0: 1.0, **{_STRIKE_EVERY_S * k: 1.2 for k in range(1, int(DURATION_S / _STRIKE_EVERY_S) + 1)}}


def _course(**what: Any) -> Course:
    unit = Arm().amplitude_m
    return Course(DURATION_S, {time: unit * factor for time, factor in _STRIKES.items()}, **what)


CLOSED_LOOP: dict[str, Course] = {
    "joint moving": _course(reference=to_and_fro(0.0, _MOVE_EVERY_S, _MOVE_S, _MOVE_RAD_S)),
    "damping on": _course(damping=lambda time_s: time_s >= SETTLING_S),
}
# Append new ones: a condition's index is part of its trials' seeds.
CONDITIONS = (*OPEN_LOOP, *CLOSED_LOOP, *OPEN_STARTS, *CLOSED_STARTS)


def regimes_of(condition: str) -> tuple[str, ...]:
    """The regimes in which a condition runs."""
    return REGIMES_STARTED if condition in OPEN_STARTS or condition in CLOSED_STARTS else REGIMES_CHANGED


@dataclass(frozen=True)
class ConditionJob:
    """One trial of one condition, for all methods."""

    condition: str
    regime: str
    trial: int
    seed: int
    methods: tuple[str, ...]


@dataclass(frozen=True)
class Withstood:
    """Results of a job by method. during: for conditions that define it."""

    job: ConditionJob
    scores: dict[str, Score]
    failures: dict[str, str]
    during: dict[str, During]


def withstand(job: ConditionJob) -> Withstood:
    """Run every method under the condition."""
    regime = REGIMES[job.regime]
    seed = seed_of(job.seed, job.trial, job.condition)
    closed = job.condition in CLOSED_LOOP or job.condition in CLOSED_STARTS
    judge = (_closed if closed else _open)(job.condition, regime, seed)
    scores, during, failures = {}, {}, {}
    for name in job.methods:
        try:
            scores[name], begun = judge(name)
            if begun is not None:
                during[name] = begun
        except Exception as failure:  # an exception is the result of this method alone
            failures[name] = f"{type(failure).__name__}: {failure}"
    return Withstood(job, scores, failures, during)


def seed_of(seed: int, trial: int, condition: str) -> tuple[int, ...]:
    """The seed of a condition's trial."""
    return (seed, trial, 3, CONDITIONS.index(condition))


@dataclass(frozen=True)
class OpenTrial:
    """A trial in open loop. scale: true image scale over that of the model."""

    condition: Condition
    data: Data
    model: Model
    scale: float


def open_trial(name: str, regime: Regime, seed: tuple[int, ...]) -> OpenTrial:
    """Draw a trial of a condition in open loop."""
    condition = OPEN_LOOP[name] if name in OPEN_LOOP else OPEN_STARTS[name]
    data = generate(
        regime, NOISE, seed, condition.duration_s, condition.arm, condition.change, condition.excite
    )
    data = condition.change_data(data, np.random.default_rng((*seed, 1)))
    scale = condition.scale_factor * (1.0 + scale_error(seed))
    return OpenTrial(condition, data, assumed_model(regime, NOISE), scale)


Judge = Callable[[str], tuple[Score, During | None]]


def _open(name: str, regime: Regime, seed: tuple[int, ...]) -> Judge:
    trial = open_trial(name, regime, seed)
    condition, data = trial.condition, trial.data

    def judge(method: str) -> tuple[Score, During | None]:
        answers = run_method(method, data, trial.model, trial.scale)
        scored = score(data, answers, condition.from_s)
        if condition.during is None:
            return scored, None
        cycles = within(condition.during(data), cycle_times(len(data.deflection_m)))
        begun = during_of(
            said_of(data, answers), cycles, cycles[data.frames.read_cycle], data.arm.amplitude_m
        )
        return scored, begun

    return judge


def _closed(name: str, regime: Regime, seed: tuple[int, ...]) -> Judge:
    course, spans = (CLOSED_LOOP[name], None) if name in CLOSED_LOOP else CLOSED_STARTS[name]
    from_s = SETTLING_S if spans is None else spans()[0][0]

    def judge(method: str) -> tuple[Score, During | None]:
        run = run_closed(method, regime, NOISE, seed, course)
        time_s = cycle_times(len(run.deflection_m))
        late = time_s >= from_s
        scored = late.copy()
        for strike in course.strikes:
            scored &= (time_s < strike) | (time_s > strike + AFTER_IMPACT_S)
        nominal_m = Arm().amplitude_m
        said = Said(
            run.deflection_m, run.predicted_m, run.predicted_std_m,
            np.full(len(time_s), nominal_m), run.delay_error_s, run.delay_std_s,
        )  # fmt: skip
        judged = score_of(said, scored, late, scored[run.frame_cycle])
        if spans is None:
            return judged, None
        cycles = within(spans(), time_s)
        return judged, during_of(said, cycles, cycles[run.frame_cycle], nominal_m)

    return judge


def condition_rows(withstood: Iterable[Withstood]) -> list[dict[str, Any]]:
    """A row for each condition, regime and method: means over the trials."""
    cells: dict[tuple[str, str], list[Withstood]] = {}
    for one in withstood:
        cells.setdefault((one.job.condition, one.job.regime), []).append(one)
    rows = []
    for (condition, regime), cell in cells.items():
        for name in cell[0].job.methods:
            scores = [one.scores[name] for one in cell if name in one.scores]
            figures = mean_score(scores)
            for timing in ("us_per_cycle", "us_per_cycle_median"):
                del figures[timing]
            rows.append(
                {
                    "condition": condition,
                    "method": name,
                    "regime": regime,
                    "noise": NOISE,
                    **figures,
                    **_during(one.during[name] for one in cell if name in one.during),
                    "trials": len(scores),
                    "failure": failure_of(one.failures.get(name) for one in cell),
                }
            )
    return rows


def _during(begun: Iterable[During]) -> dict[str, float | None]:
    """Means over the trials; None if a condition has no such figures."""
    rows = [asdict(one) for one in begun]
    row: dict[str, float | None] = {}
    for figure in FIGURES:
        values = [one[figure] for one in rows if isfinite(one[figure])]
        row[figure] = float(np.mean(values)) if values else None
    return row
