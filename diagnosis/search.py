"""Which causes are in the data: screened, refitted, and decided by what they predict of the held-out part."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import erf, sqrt

import numpy as np
from numpy.typing import NDArray

from common.causes import CAUSES as CATALOGUE
from diagnosis.catalogue import CAUSES
from diagnosis.cause import Cause
from diagnosis.fit import Data, Fit, Split, fit, make_data
from diagnosis.impacts import carried, pruned, refit_with
from diagnosis.laws import LawFound, backward_steps, laws
from diagnosis.screen import Screening, screen, variant
from diagnosis.world import World

Array = NDArray[np.float64]

MOST_CAUSES = 4
_REFITTED = 7  # causes
_STARTS = 2  # of each
_LEAST_HELD_NATS = 3.0


@dataclass(frozen=True)
class Candidate:
    """A cause refitted. law: set for a law of noise or timing, which changes no fit."""

    cause: str
    fit: Fit
    train_gain: float
    held_gain: float
    held_std: float
    block_gains: Array
    values: dict[str, tuple[float, float]]
    law: LawFound | None = None
    free: tuple[str, ...] = ()
    note: str = ""


@dataclass
class Stage:
    """One step of the search: what was screened, who was refitted (best first), who was taken."""

    screening: Screening
    candidates: list[Candidate]
    taken: Candidate | None


@dataclass
class Found:
    """The search's end: the fit with all findings, each with its candidates at the time."""

    baseline: Fit
    final: Fit
    findings: list[Candidate] = field(default_factory=list)
    stages: list[Stage] = field(default_factory=list)


def block_gain(after: Fit, before: Fit) -> Array:
    """Held-out log-likelihood gained, per held-out block."""
    return after.held_nats - before.held_nats


def _spread(gains: Array, held: NDArray[np.bool_]) -> float:
    """Standard error of the gains' sum over held-out blocks."""
    one = gains[held]
    return float(np.std(one, ddof=1) * sqrt(len(one))) if len(one) > 1 else float(abs(one.sum()))


def search(
    baseline: Fit,
    split: Split,
    tick: Callable[[float, str], None] = lambda done, what: None,
    only: Sequence[str] | None = None,
) -> Found:
    """Take causes one after another while one predicts the held-out part better; then drop those made needless."""
    found = Found(baseline, baseline)
    taken: dict[str, Candidate] = {}
    free: tuple[str, ...] = ()
    for step in range(MOST_CAUSES + 1):
        last = found.final
        data = make_data(last.world, split)
        tick(step / (MOST_CAUSES + 1), f"causes, round {step + 1}")
        names = [name for name in CAUSES if name not in taken and (only is None or name in only)]
        known = found.stages[0].screening.threshold_nats if found.stages else None
        stage = _stage(data, last, split, [CAUSES[name] for name in names], taken, free, known)
        found.stages.append(stage)
        if stage.taken is None or step == MOST_CAUSES:
            break
        taken[stage.taken.cause] = stage.taken
        found.findings.append(stage.taken)
        if stage.taken.law is None:
            free = (*free, *stage.taken.free)
            found.final = pruned(stage.taken.fit, split, free)
    _drop_needless(found, split)
    return found


def _stage(
    data: Data,
    last: Fit,
    split: Split,
    causes: list[Cause],
    taken: dict[str, Candidate],
    free: tuple[str, ...],
    threshold: float | None,
) -> Stage:
    screening = screen(data, last, causes, threshold_nats=threshold)
    candidates = [
        _of_law(data, last, law)
        for law in (*laws(data, last), *backward_steps(data))
        if law.cause not in taken
    ]
    starts: dict[str, int] = {}
    refits: list[tuple[Cause, Fit]] = []
    for one in screening.scored:
        if one.nats < screening.threshold_nats:
            continue
        if one.cause.id not in starts and len(starts) >= _REFITTED:
            continue
        if starts.get(one.cause.id, 0) >= _STARTS:
            continue
        starts[one.cause.id] = starts.get(one.cause.id, 0) + 1
        extra = (*free, *one.cause.free(one.world))
        names = tuple(dict.fromkeys((*one.world.baseline_names(), *extra)))
        refits.append(
            (one.cause, fit(make_data(one.world, split), one.start, names, iterations=6, colour=last.colour))
        )
    top = max((refitted.train_nats for _, refitted in refits), default=0.0)
    for cause, refitted in refits:
        within = refitted.train_nats - last.train_nats > 0.5 * (top - last.train_nats)
        done = _settled(refitted, cause, split) if within else refitted
        candidates.append(_of_fit(cause, done, last, split))
    best: dict[str, Candidate] = {}
    for candidate in candidates:
        rival = best.get(candidate.cause)
        if rival is None or candidate.train_gain > rival.train_gain:
            best[candidate.cause] = candidate
    ranked = sorted(best.values(), key=lambda one: -_merit(one))
    chosen = next((one for one in ranked if _convincing(one, screening, data)), None)
    return Stage(screening, ranked, chosen)


def _merit(one: Candidate) -> float:
    """Held-out gain, less what each number beyond the first costs."""
    return one.held_gain - 1.0 * (max(len(one.free), 1) - 1)


def _convincing(one: Candidate, screening: Screening, data: Data) -> bool:
    """Whether the gain is more than chance: on the part that was searched, and on the held-out part."""
    penalty = _LEAST_HELD_NATS + 0.5 * len(one.free)
    return (
        one.train_gain > screening.threshold_nats
        and one.held_gain > penalty
        and one.held_gain > one.held_std
        and _plausible(one)
    )


def _plausible(one: Candidate) -> bool:
    """Whether every parameter lies where the catalogue has it."""
    known = {parameter.name: parameter for parameter in CATALOGUE[one.cause].parameters}
    for name, (value, _) in one.values.items():
        parameter = known.get(name)
        if parameter is not None and parameter.kind in ("number", "whole"):
            slack = 1e-9 * max(abs(parameter.lowest), abs(parameter.highest))
            if not parameter.lowest - slack <= value <= parameter.highest + slack:
                return False
    return True


def _of_law(data: Data, last: Fit, law: LawFound) -> Candidate:
    held = data.split.held
    return Candidate(
        law.cause, last, law.train_nats, float(law.held_nats[held].sum()), _spread(law.held_nats, held),
        law.held_nats, law.values, law, tuple(law.values), law.note,
    )  # fmt: skip


def _of_fit(cause: Cause, refitted: Fit, last: Fit, split: Split) -> Candidate:
    gains = block_gain(refitted, last)
    return Candidate(
        cause.id,
        refitted,
        refitted.train_nats - last.train_nats,
        float(gains[split.held].sum()),
        _spread(gains, split.held),
        gains,
        cause.parameters_of(refitted),
        None,
        cause.free(refitted.world),
    )


def _settled(refitted: Fit, cause: Cause, split: Split) -> Fit:
    """To the end: a search along quantities without a smooth derivative, the step halved, then all fitted anew."""
    best = refitted
    data = make_data(best.world, split)
    own = cause.free(best.world)
    for name, first in cause.settle.items():
        at = best.world.space.place[name]
        onset = "onset" in name
        step = first * (1.0 if onset else max(abs(best.value(name)), 1e-3) * 10.0)
        least = 4.0 * best.world.measured.cycle_s if onset else 0.02 * step
        while step > least:
            moved = False
            for sign in (1.0, -1.0):
                start = best.vector.copy()
                start[at] += sign * step
                trial = fit(data, start, [n for n in own if n != name], iterations=1, colour=best.colour)
                if trial.train_nats > best.train_nats + 0.02:
                    best, moved = trial, True
                    break
            if not moved:
                step *= 0.4
    return fit(data, best.vector, refitted.free, iterations=8, colour=best.colour)


def _drop_needless(found: Found, split: Split) -> None:
    """Findings that later ones have made needless go again."""
    while len(found.findings) > 1:
        fits = [one for one in found.findings if one.law is None]
        if len(fits) < 2:
            return
        losses = []
        for one in fits:
            rest = tuple(name for other in fits if other is not one for name in other.free)
            cause = CAUSES[one.cause]
            world = found.final.world
            start = found.final.vector.copy()
            neutral = world.space.vector()
            for name in cause.free(world):
                start[world.space.place[name]] = neutral[world.space.place[name]]
            if cause.id == "second_bending_mode":
                world = variant(world, {"extra_modes": -1})
                start = carried(found.final, world)
            names = tuple(dict.fromkeys((*world.baseline_names(), *rest)))
            without = fit(make_data(world, split), start, names, colour=found.final.colour)
            losses.append(
                (float((found.final.held_nats - without.held_nats)[split.held].sum()), one, without)
            )
        least, one, without = min(losses, key=lambda loss: loss[0])
        if least > _LEAST_HELD_NATS:
            return
        found.findings.remove(one)
        found.final = without


def confidence(stage: Stage) -> float:
    """Probability that the one taken is the right one: by its lead over the next, in standard errors over blocks."""
    taken = stage.taken
    if taken is None:
        return 0.0
    rivals = [one for one in stage.candidates if one.cause != taken.cause]
    certain = 0.5 * (1.0 + erf((taken.held_gain / max(taken.held_std, 1.0)) / sqrt(2.0)))
    if not rivals:
        return min(0.99, certain)
    rival = max(rivals, key=_merit)
    lead = _merit(taken) - _merit(rival)
    difference = taken.block_gains - rival.block_gains
    spread = max(float(np.std(difference) * sqrt(max(int(np.count_nonzero(difference)), 1))), 2.0)
    return float(min(0.99, certain * 0.5 * (1.0 + erf(lead / spread / sqrt(2.0)))))


def inseparable(stage: Stage) -> list[str]:
    """Causes that predict the held-out part as well as the one taken, as far as it can be told."""
    taken = stage.taken
    if taken is None:
        return []
    near = []
    for one in stage.candidates:
        if one.cause == taken.cause or one.law is not None:
            continue
        difference = taken.block_gains - one.block_gains
        spread = float(np.std(difference) * sqrt(max(int(np.count_nonzero(difference)), 1)))
        lead = float(difference.sum())
        train = taken.train_gain - one.train_gain
        if lead < max(2.0, spread) and train < 6.0 and one.held_gain > 0.7 * taken.held_gain:
            near.append(one.cause)
    return near


__all__ = ["Candidate", "Found", "Stage", "World", "confidence", "inseparable", "refit_with", "search"]
