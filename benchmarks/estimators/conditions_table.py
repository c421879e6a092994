"""The third table: what the methods were not told, what they lose, and what moves."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from math import cos, pi
from typing import Any

import numpy as np

from benchmarks.estimators.closed_loop import Course, run_closed
from benchmarks.estimators.generator import Change, Data, generate
from benchmarks.estimators.regimes import AFTER_BLOW_S, CYCLE_S, DURATION_S, REGIMES, SETTLING_S, Arm, Regime
from benchmarks.estimators.tables import failure_of, mean_score
from benchmarks.estimators.trial import Said, Score, assumed_model, run_method, scale_error, score, score_of

REGIMES_CHANGED = ("freerun drift", "triggered drift")
NOISE = 0.3
ONSET_S = 20.0
_STRIKE_EVERY_S = 2.7
_MOVE_EVERY_S, _MOVE_S, _MOVE_RAD_S = 4.0, 1.5, 0.1


_AS_TOLD = Arm()


@dataclass(frozen=True)
class Condition:
    """A departure from what the methods are told. from_s: scored from then on; duration_s: of the trial.

    change_data: what befalls the measurements, given the trial and a source of chance.
    """

    arm: Arm = _AS_TOLD
    change: Change | None = None
    scale_factor: float = 1.0
    duration_s: float = DURATION_S
    from_s: float = SETTLING_S
    change_data: Callable[[Data, np.random.Generator], Data] = lambda data, random: data


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
    """The scene comes 20 % nearer, in 20 s from 10 s on."""
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
        Arm(damping_ratio=0.0, blow_every_s=(1e3, 2e3), blow_to=(1.0, 1.0))
    ),
}


def _moves(time_s: float) -> float:
    """Joint velocity reference: to and fro, each move a raised cosine."""
    move, since = divmod(time_s, _MOVE_EVERY_S)
    if since > _MOVE_S:
        return 0.0
    return (1.0 if move % 2 == 0 else -1.0) * _MOVE_RAD_S * 0.5 * (1.0 - cos(2.0 * pi * since / _MOVE_S))


_STRIKES = {0.0: 1.0, **{_STRIKE_EVERY_S * k: 1.2 for k in range(1, int(DURATION_S / _STRIKE_EVERY_S) + 1)}}


def _course(**what: Any) -> Course:
    unit = Arm().amplitude_m
    return Course(DURATION_S, {time: unit * factor for time, factor in _STRIKES.items()}, **what)


CLOSED_LOOP: dict[str, Course] = {
    "joint moving": _course(reference=_moves),
    "damping on": _course(damping=lambda time_s: time_s >= SETTLING_S),
}
CONDITIONS = (*OPEN_LOOP, *CLOSED_LOOP)


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
    """What came of it, by method."""

    job: ConditionJob
    scores: dict[str, Score]
    failures: dict[str, str]


def withstand(job: ConditionJob) -> Withstood:
    """Run every method under the condition."""
    regime = REGIMES[job.regime]
    seed = (job.seed, job.trial, 3, CONDITIONS.index(job.condition))
    judge = (
        _closed(job.condition, regime, seed)
        if job.condition in CLOSED_LOOP
        else _open(job.condition, regime, seed)
    )
    scores, failures = {}, {}
    for name in job.methods:
        try:
            scores[name] = judge(name)
        except Exception as failure:  # whatever it raises is this method's result and no other's
            failures[name] = f"{type(failure).__name__}: {failure}"
    return Withstood(job, scores, failures)


def _open(name: str, regime: Regime, seed: tuple[int, ...]) -> Callable[[str], Score]:
    condition = OPEN_LOOP[name]
    data = generate(regime, NOISE, seed, condition.duration_s, condition.arm, condition.change)
    data = condition.change_data(data, np.random.default_rng((*seed, 1)))
    model = assumed_model(regime, NOISE)
    scale = condition.scale_factor * (1.0 + scale_error(seed))
    return lambda method: score(data, run_method(method, data, model, scale), condition.from_s)


def _closed(name: str, regime: Regime, seed: tuple[int, ...]) -> Callable[[str], Score]:
    course = CLOSED_LOOP[name]

    def judge(method: str) -> Score:
        run = run_closed(method, regime, NOISE, seed, course)
        time_s = np.arange(len(run.deflection_m)) * CYCLE_S
        late = time_s >= SETTLING_S
        scored = late.copy()
        for strike in course.strikes:
            scored &= (time_s < strike) | (time_s > strike + AFTER_BLOW_S)
        said = Said(
            run.deflection_m, run.predicted_m, run.predicted_std_m,
            np.full(len(time_s), Arm().amplitude_m), run.delay_error_s, run.delay_std_s,
        )  # fmt: skip
        return score_of(said, scored, late, scored[run.frame_cycle])

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
                    "trials": len(scores),
                    "failure": failure_of(one.failures.get(name) for one in cell),
                }
            )
    return rows
