"""Which causes are in the data: screened, refitted, and decided by what they predict of the held-out part."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import erf, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from common.causes import CAUSES as CATALOGUE
from diagnosis.catalogue import CAUSES
from diagnosis.cause import Cause
from diagnosis.fit import Data, Fit, Split, colours, fit, make_data, strayed
from diagnosis.impacts import carried, pruned, with_hidden_blows
from diagnosis.laws import LawFound, backward_steps, laws
from diagnosis.screen import Scored, Screening, screen, variant

Array = NDArray[np.float64]

MOST_CAUSES = 4
_REFITTED = 7  # causes
_STARTS = 2  # of each
_ITERATIONS, _ITERATIONS_FAR = 6, 15
_LEAST_HELD_NATS = 3.0


@dataclass(frozen=True)
class Candidate:
    """A cause refitted. law: set for a law of noise or timing, which changes no fit. certain: the data show it by
    themselves, so that its gain need not be the same in all blocks."""

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
    surprise: float = 0.0
    certain: bool = False


@dataclass
class Stage:
    """One step of the search: what was screened, who was refitted (best first), who was taken.

    other_names: causes that a later stage would have added, and that explain the same thing.
    """

    screening: Screening
    candidates: list[Candidate]
    taken: Candidate | None
    other_names: list[str] = field(default_factory=list)


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
    known: Sequence[LawFound] = (),
) -> Found:
    """Take causes one after another while one predicts the held-out part better; then drop those made needless.

    known: laws that were found while the data were read: a clock that steps.
    """
    found = Found(baseline, baseline)
    taken: dict[str, Candidate] = {}
    first = make_data(baseline.world, split)
    for law in (*known, *backward_steps(first)):
        one = _of_law(first, baseline, law)
        taken[law.cause] = one
        found.findings.append(one)
        found.stages.append(Stage(Screening([], 0.0), [one], one))
    free: tuple[str, ...] = ()
    for step in range(MOST_CAUSES + 1):
        last = found.final
        data = make_data(last.world, split)
        tick(step / (MOST_CAUSES + 1), f"causes, round {step + 1}")
        names = [name for name in CAUSES if name not in taken and (only is None or name in only)]
        screened = [stage.screening.threshold_nats for stage in found.stages if stage.screening.scored]
        threshold = screened[0] if screened else None
        stage = _stage(data, last, split, [CAUSES[name] for name in names], taken, free, threshold)
        stage.taken = _next(stage, found, data)
        found.stages.append(stage)
        if stage.taken is None or step == MOST_CAUSES:
            break
        taken[stage.taken.cause] = stage.taken
        found.findings.append(stage.taken)
        if stage.taken.law is None:
            found.final = _completed(stage.taken, split, (*free, *stage.taken.free))
            usual = set(found.final.world.baseline_names())
            free = tuple(name for name in found.final.free if name not in usual)
    _drop_needless(found, split)
    return found


def _completed(taken: Candidate, split: Split, free: tuple[str, ...]) -> Fit:
    """The fit of a cause that is taken: without blows that were none, with those that it hid, and with the law of the
    arrivals as it is without the cause in it."""
    kept = pruned(taken.fit, split, free)
    final = with_hidden_blows(kept, split, free)
    if final.world.impacts != kept.world.impacts:
        final = _settled(final, CAUSES[taken.cause], split)
    if CATALOGUE[taken.cause].place == "timing" and "arrival" in final.colour:
        data = make_data(final.world, split)
        now = final.colour | {"arrival": colours(data, final.vector)["arrival"]}
        final = fit(data, final.vector, final.free, colour=now)
    return final


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
    by_law = [_of_law(data, last, law) for law in laws(data, last) if law.cause not in taken]
    refits = [(one.cause, _refitted(one, free, last, split)) for one in _to_refit(screening)]
    top = max((refitted.train_nats for _, refitted in refits), default=0.0)
    near = [
        (cause, _settled(refitted, cause, split))
        if refitted.train_nats - last.train_nats > 0.5 * (top - last.train_nats)
        else (cause, refitted)
        for cause, refitted in refits
    ]
    certain = {one.cause.id for one in screening.scored if one.trial.certain}
    fits = (_of_fit(cause, one, last, split) for cause, one in near)
    ranked = _ranked([*by_law, *(replace(one, certain=one.cause in certain) for one in fits)])
    chosen = _chosen(ranked, screening, data)
    if _in_doubt(chosen, ranked) and top - last.train_nats > 2.0 * screening.threshold_nats:
        others = _ranked([*by_law, *_with_straying(data, last, split, near, free)])
        other = _chosen(others, screening, data)
        if other is not None and (chosen is None or other.law is None):
            ranked, chosen = others, other
    return Stage(screening, ranked, chosen)


_OVERLAP = 0.6
_LEAST_OF_A_LAW = 0.25
_LEAST_SHARE, _LEAST_SHARE_ELSEWHERE = 0.04, 0.01


def _next(stage: Stage, found: Found, data: Data) -> Candidate | None:
    """The stage's best that adds something of its own: no other name for what is already found, and no small change
    that the first finding's simple form would leave of its true one."""
    for one in [stage.taken, *stage.candidates] if stage.taken is not None else []:
        if not _convincing(one, stage.screening, data):
            continue
        if found.findings and one.law is None and one.held_gain < _least_share(one, found.findings[0]):
            continue
        rivals = [earlier for earlier in found.stages if _same_thing(earlier, one)]
        if not rivals:
            return one
        for earlier in rivals:
            earlier.other_names.append(one.cause)
    return None


def _least_share(one: Candidate, first: Candidate) -> float:
    """Nats that a simple form may leave of its true one: in the same place more than elsewhere, and a sensor's none
    outside of its own channel."""
    here, there = CATALOGUE[one.cause].place, CATALOGUE[first.cause].place
    if here == there:
        return _LEAST_SHARE * first.held_gain
    return _LEAST_SHARE_ELSEWHERE * first.held_gain if there in ("arm", "drive") else 0.0


def _same_thing(earlier: Stage, one: Candidate) -> bool:
    """Whether a cause explained alone most of what was then taken, and adds little to it: one thing, two names."""
    taken = earlier.taken
    alone = next((c for c in earlier.candidates if c.cause == one.cause), None)
    if taken is None or alone is None or taken.law is not None or one.law is not None:
        return False
    whole, by_itself = taken.train_gain + taken.held_gain, alone.train_gain + alone.held_gain
    added = one.train_gain + one.held_gain
    return by_itself > _OVERLAP * whole and added < _OVERLAP * by_itself


def _chosen(ranked: list[Candidate], screening: Screening, data: Data) -> Candidate | None:
    """The best that convinces; laws wait until no cause of another kind does, as what a wrong simulation leaves looks
    like noise of another law: but not for one that explains far less than they do."""
    convincing = [one for one in ranked if _convincing(one, screening, data)]
    by_law = max((_both(one) for one in convincing if one.law is not None), default=0.0)
    convincing.sort(
        key=lambda one: (
            one.law is None and _both(one) < _LEAST_OF_A_LAW * by_law, not one.certain, one.law is not None,
        )
    )  # stable: the best first within each  # fmt: skip
    return convincing[0] if convincing else None


def _both(one: Candidate) -> float:
    return one.train_gain + one.held_gain


_DISAGREE = 0.1


def _in_doubt(chosen: Candidate | None, ranked: list[Candidate]) -> bool:
    """Whether nothing convinces, or what is held out speaks against the cause that explains most: something strays."""
    if chosen is None or chosen.law is not None:
        return True
    if chosen.certain:
        return False
    most = max(one.train_gain for one in ranked if one.law is None)
    return chosen.train_gain < (1.0 - _DISAGREE) * most


def _to_refit(screening: Screening) -> list[Scored]:
    """The best trials of the best causes, and those that the data ask for whatever the score."""
    starts: dict[str, int] = {}
    asked = []
    for one in screening.scored:
        if one.trial.asked:
            asked.append(one)
            continue
        if one.nats < screening.threshold_nats:
            continue
        if one.cause.id not in starts and len(starts) >= _REFITTED:
            continue
        if starts.get(one.cause.id, 0) >= _STARTS:
            continue
        starts[one.cause.id] = starts.get(one.cause.id, 0) + 1
        asked.append(one)
    return asked


def _refitted(one: Scored, free: tuple[str, ...], last: Fit, split: Split) -> Fit:
    names = tuple(dict.fromkeys((*one.world.baseline_names(), *free, *one.cause.free(one.world))))
    turns = _ITERATIONS_FAR if one.trial.exact else _ITERATIONS
    return fit(make_data(one.world, split), one.start, names, iterations=turns, colour=last.colour)


def _with_straying(
    data: Data, last: Fit, split: Split, refits: list[tuple[Cause, Fit]], free: tuple[str, ...]
) -> list[Candidate]:
    """The leading candidates once more, what the best of them leaves taken for noise that strays slowly."""
    best = max((one for _, one in refits), key=lambda one: one.train_nats)
    colour = strayed(make_data(best.world, split), best)
    if all(colour[name] == last.colour.get(name) for name in colour):
        return []
    again = fit(data, last.vector, last.free, iterations=8, colour=colour)
    found = []
    for cause, one in refits:
        if one.train_nats - last.train_nats > 0.3 * (best.train_nats - last.train_nats):
            other = fit(make_data(one.world, split), one.vector, one.free, iterations=8, colour=colour)
            found.append(_of_fit(cause, other, again, split))
    return found


def _ranked(candidates: list[Candidate]) -> list[Candidate]:
    """The best of each cause, best first."""
    best: dict[str, Candidate] = {}
    for candidate in candidates:
        rival = best.get(candidate.cause)
        if rival is None or candidate.train_gain > rival.train_gain:
            best[candidate.cause] = candidate
    return sorted(best.values(), key=lambda one: -_merit(one))


def _merit(one: Candidate) -> float:
    """Held-out gain, less what each number beyond the first costs, and what is unlikely before any data."""
    return one.held_gain - 1.0 * (max(len(one.free), 1) - 1) - one.surprise


def _convincing(one: Candidate, screening: Screening, data: Data) -> bool:
    """Whether the gain is more than chance: on the part that was searched, and on the held-out part."""
    penalty = _LEAST_HELD_NATS + 0.5 * len(one.free)
    if (
        one.law is None and _onset_of(CAUSES[one.cause]) is not None
    ):  # it may lie in the held-out part altogether
        return (
            one.held_gain > 0.0
            and one.train_gain + one.held_gain > screening.threshold_nats + penalty
            and _plausible(one)
        )
    return (
        one.train_gain > screening.threshold_nats
        and one.held_gain > penalty
        and (one.certain or one.held_gain > one.held_std)
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
    everywhere = np.ones(len(law.held_nats), bool)
    return Candidate(
        law.cause, last, law.train_nats, float(law.held_nats.sum()), _spread(law.held_nats, everywhere),
        law.held_nats, law.values, law, tuple(law.values), law.note,
    )  # fmt: skip


def _of_fit(cause: Cause, refitted: Fit, last: Fit, split: Split) -> Candidate:
    refitted, spread = _onset_seen(refitted, cause, split)
    gains = block_gain(refitted, last)
    values = cause.parameters_of(refitted)
    if "onset_s" in values:
        values["onset_s"] = (values["onset_s"][0], spread)
    return Candidate(
        cause.id,
        refitted,
        refitted.train_nats - last.train_nats,
        float(gains[split.held].sum()),
        _spread(gains, split.held),
        gains,
        values,
        None,
        cause.free(refitted.world),
        surprise=cause.surprise(refitted),
    )


_ONSETS = 41
_JUST_S = 1e-7  # before a frame
_ONSET_REACH_S = 0.8


def _onset_seen(refitted: Fit, cause: Cause, split: Split) -> tuple[Fit, float]:
    """The likeliest onset, and its standard deviation, s. What happens once may happen where it is held out, and no
    other part tells when: so all data locate it, and what the held-out part is worth is the logarithm of its mean
    likelihood over all onsets, each by what the training part has for it."""
    name = _onset_of(cause)
    if name is None:
        return refitted, 0.0
    now = refitted.value(name)
    received = refitted.world.in_order_s
    if name.startswith("timing.") and len(received) > 2:
        tried = received[np.abs(received - now) < _ONSET_REACH_S] - _JUST_S
    else:
        tried = now + np.linspace(-_ONSET_REACH_S, _ONSET_REACH_S, _ONSETS)
    if len(tried) < 3:
        return refitted, 0.0
    train, held = _by_onset(refitted, name, tried, split)
    best = int(np.argmax(train + held.sum(axis=1)))
    vector = refitted.vector.copy()
    vector[refitted.world.space.place[name]] = tried[best]
    moved = fit(make_data(refitted.world, split), vector, refitted.free, iterations=3, colour=refitted.colour)
    train, held = _by_onset(moved, name, tried, split)
    odds = _odds(train)
    averaged = logsumexp(np.log(np.maximum(odds, 1e-300))[:, None] + held, axis=0)
    located = _odds(train + held.sum(axis=1))
    spread = float(np.sqrt(located @ (tried - located @ tried) ** 2)) + 0.25 * float(
        np.median(np.diff(tried))
    )
    return replace(moved, held_nats=averaged), spread


def _odds(nats: Array) -> Array:
    odds = np.exp(nats - nats.max())
    known: Array = odds / odds.sum()
    return known


def _by_onset(one: Fit, name: str, tried: Array, split: Split) -> tuple[Array, Array]:
    """Log-likelihood of the training part, and of each held-out block, for each onset."""
    data = make_data(one.world, split)
    train, held = np.empty(len(tried)), np.empty((len(tried), len(split.held)))
    for k, onset in enumerate(tried):
        vector = one.vector.copy()
        vector[one.world.space.place[name]] = onset
        there = fit(data, vector, (), iterations=0, colour=one.colour)
        train[k], held[k] = there.train_nats, there.held_nats
    return train, held


def _onset_of(cause: Cause) -> str | None:
    """The quantity that is an instant at which something happens once."""
    return next((name for name in cause.settle if "onset" in name), None)


def _settled(refitted: Fit, cause: Cause, split: Split) -> Fit:
    """To the end: a search along quantities without a smooth derivative, the step halved, then all fitted anew."""
    best = refitted
    data = make_data(best.world, split)
    own = cause.free(best.world)
    for name, first in cause.settle.items():
        at = best.world.space.place[name]
        onset = "onset" in name
        # a change of the arm's motion turns the phase of all that follows
        along = refitted.free if name == "arm.onset_s" else own
        step = first * (1.0 if onset else max(abs(best.value(name)), 1e-3) * 10.0)
        least = 4.0 * best.world.measured.cycle_s if onset else 0.02 * step
        while step > least:
            moved = False
            for sign in (1.0, -1.0):
                start = best.vector.copy()
                start[at] += sign * step
                trial = fit(data, start, [n for n in along if n != name], iterations=1, colour=best.colour)
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
            rest = tuple(name for name in rest if name in world.space.place)
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
    """Causes that predict the held-out part as well as the one taken, as far as it can be told, or that are likelier
    by all data together."""
    taken = stage.taken
    if taken is None or taken.law is not None:
        return []
    near = []
    for one in stage.candidates:
        if one.cause == taken.cause or one.law is not None:
            continue
        difference = taken.block_gains - one.block_gains
        spread = float(np.std(difference) * sqrt(max(int(np.count_nonzero(difference)), 1)))
        lead = float(difference.sum()) + one.surprise - taken.surprise
        train = taken.train_gain - one.train_gain + one.surprise - taken.surprise
        as_good = (lead < max(2.0, spread) and train < 6.0) or lead + train < 0.0
        if (as_good and one.held_gain > 0.7 * taken.held_gain) or one.cause in stage.other_names:
            near.append(one.cause)
    return near
