"""Which causes are in the data: screened, refitted, and decided by what they predict of the held-out part."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.common.causes import CAUSES as CATALOGUE
from stillarm.diagnosis.budget import OutOfTime
from stillarm.diagnosis.candidate import Candidate, Found, Stage
from stillarm.diagnosis.catalogue import CAUSES
from stillarm.diagnosis.cause import Cause
from stillarm.diagnosis.choice import (
    ALL,
    LEAST_HELD_NATS,
    Rest,
    by_all_blocks,
    choose,
    in_doubt,
    next_to_take,
    rank,
    rest,
    too_small,
)
from stillarm.diagnosis.fit import Colours, Data, Fit, Split, colours, fit, make_data, strayed
from stillarm.diagnosis.impacts import carried_over, pruned, with_hidden_impacts
from stillarm.diagnosis.laws import LawFound, backward_steps, laws
from stillarm.diagnosis.lost_modes import with_lost_modes
from stillarm.diagnosis.moving_part import begun_on_what_moves
from stillarm.diagnosis.onset import AT_ONCE, onset_of, onset_seen, settled
from stillarm.diagnosis.screen import Scored, Screening, screen, variant
from stillarm.diagnosis.seen_at_joint import most_left_elsewhere
from stillarm.diagnosis.side_by_side import meanwhile, side_by_side
from stillarm.diagnosis.structure import examine
from stillarm.diagnosis.unpredictable import predictable

Array = NDArray[np.float64]

MOST_CAUSES = 4
_REFITTED = 7  # causes
_STARTS = 2  # of each
_ITERATIONS, _ITERATIONS_FAR = 6, 15
_SHARE_TO_BEGIN_ANEW = 0.1  # of what the best cause explains


def block_gain(after: Fit, before: Fit) -> Array:
    """Held-out log-likelihood gained, per held-out block."""
    return after.held_out_score - before.held_out_score


def _gain_where_predictable(after: Fit, before: Fit, split: Split) -> Array:
    """The same where both could have foretold the block: elsewhere a thousand nats either way would take, or drop, the
    very cause that explains the recording. A mode that a fit adds has a state after a blow, too."""
    gains = block_gain(after, before)
    gains[~(predictable(split, before) & predictable(split, after, closely=True))] = 0.0
    return gains


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
        tick(step / (MOST_CAUSES + 1), f"causes, round {step + 1}")
        try:
            best = _round(found, split, taken, free, only, last_round=step == MOST_CAUSES)
        except OutOfTime:
            found.left_out.append(f"causes, round {step + 1}")
            return found
        if best is None or step == MOST_CAUSES:
            break
        taken[best.cause] = best
        found.findings.append(best)
        if best.law is None:
            found.final = best.fit
            usual = set(found.final.world.baseline_names())
            free = tuple(name for name in found.final.free if name not in usual)
    try:
        _drop_needless(found, split)
    except OutOfTime:
        found.left_out.append("causes that later ones made needless")
    return found


def _round(
    found: Found,
    split: Split,
    taken: dict[str, Candidate],
    free: tuple[str, ...],
    only: Sequence[str] | None,
    last_round: bool,
) -> Candidate | None:
    """One round of the search, its stage noted; the cause to take, with all that its fit needs. last_round: nothing is
    taken any more."""
    last = found.final
    data = make_data(last.world, split)
    names = [name for name in CAUSES if name not in taken and (only is None or name in only)]
    screened = [stage.screening.threshold_nats for stage in found.stages if stage.screening.scored]
    threshold = screened[0] if screened else None
    causes = [CAUSES[name] for name in names]
    stage = _stage(data, last, split, causes, taken, free, threshold)
    elsewhere = _left_elsewhere(found, split, threshold)
    best = next_to_take(stage, found, _rest_of(last, found.known_laws, split), elsewhere)
    strays = None
    if best is None and found.final is not found.baseline and not last_round:
        strays = _under(data, last, strayed(data, last))
    if strays is not None:
        other = _stage(data, strays, split, causes, taken, free, threshold)
        best = next_to_take(other, found, _rest_of(strays, found.known_laws, split), elsewhere)
        if best is not None:
            stage, best = _with_fit(other, best, _as_before(best, last, split))
    if best is not None and best.law is None and not last_round:
        stage, best = _with_fit(stage, best, _completed(best, split, (*free, *best.free)))
    stage.taken = best
    found.stages.append(stage)
    return best


def _under(data: Data, last: Fit, colour: Colours) -> Fit | None:
    """What was found, fitted under another noise, such as what strays slowly; None where it is no other. What a simple
    form leaves, taken for white, raises the level of all noise, of which a small cause elsewhere seems to be a part."""
    if all(colour[name] == last.colour.get(name) for name in colour):
        return None
    return fit(data, last.vector, last.free, iterations=8, colour=colour)


def _as_before(one: Candidate, last: Fit, split: Split) -> Fit:
    """A candidate's fit under the noise of the last one."""
    if one.law is not None:
        return last
    return fit(make_data(one.fit.world, split), one.fit.vector, one.fit.free, colour=last.colour)


def _with_fit(stage: Stage, one: Candidate, other: Fit) -> tuple[Stage, Candidate]:
    """A stage in which one of its candidates has another fit, and that candidate."""
    new = replace(one, fit=other)
    return replace(stage, candidates=[new if each is one else each for each in stage.candidates]), new


def _rest_of(last: Fit, known_laws: frozenset[str], split: Split) -> Callable[[Candidate], Rest]:
    """Tells what is left of the data with a candidate, beside what the last fit leaves: both under the same noise, as
    what strays is otherwise taken for what the candidate explains."""

    def left(of: Fit) -> dict[str, float]:
        return examine(make_data(of.world, split), of, known_laws).left

    @cache  # looked at where a candidate asks for it, and once
    def without() -> dict[str, float]:
        return left(last)

    return lambda one: rest(one.train_gain, without(), left(one.fit)) if without() else ALL


def _left_elsewhere(found: Found, split: Split, threshold: float | None) -> Callable[[], dict[str, float]]:
    """Tells the nats that findings' simple forms leave at most in other places; looked at once, too."""
    return cache(lambda: most_left_elsewhere(found, split, threshold or LEAST_HELD_NATS))


def _completed(taken: Candidate, split: Split, free: tuple[str, ...]) -> Fit:
    """The fit of a cause that is taken: without blows that were none, with those that it hid, and with the law of the
    arrivals as it is without the cause in it."""
    kept = pruned(taken.fit, split, free)
    final = with_hidden_impacts(kept, split, free)
    if final.world.impacts != kept.world.impacts:
        final = settled(final, CAUSES[taken.cause], split)
    final = with_lost_modes(final, split)
    if CATALOGUE[taken.cause].place == "timing" and "arrival" in final.colour:
        final = _with_own_wander(final, split)
    return final


def _with_own_wander(one: Fit, split: Split) -> Fit:
    """A fit with the law of the arrivals as it is beside what the fit holds."""
    data = make_data(one.world, split)
    now = {name: law for name, law in colours(data, one.vector).items() if name == "arrival"}
    return fit(data, one.vector, one.free, colour=one.colour | now)


def _stage(
    data: Data,
    last: Fit,
    split: Split,
    causes: list[Cause],
    taken: dict[str, Candidate],
    free: tuple[str, ...],
    threshold: float | None,
) -> Stage:
    found_laws = meanwhile(laws, data, last)
    screening = screen(data, last, causes, threshold_nats=threshold)
    by_law = [_of_law(data, last, law) for law in found_laws.result() if law.cause not in taken]
    refits = side_by_side(lambda one: (one.cause, _refitted(one, free, last, split)), _to_refit(screening))
    refits = [(cause, one) for cause, one in _held_begun_anew(refits, last, split) if cause.possible(one)]
    top = max((refitted.train_log_likelihood for _, refitted in refits), default=last.train_log_likelihood)

    def near_the_top(one: tuple[Cause, Fit]) -> tuple[Cause, Fit]:
        cause, refitted = one
        close = refitted.train_log_likelihood - last.train_log_likelihood > 0.5 * (
            top - last.train_log_likelihood
        )
        return cause, with_lost_modes(settled(refitted, cause, split), split) if close else refitted

    near = side_by_side(near_the_top, refits)
    certain = {one.cause.id for one in screening.scored if one.trial.certain}
    fits = (_of_fit(cause, one, last, split) for cause, one in near)
    ranked = rank([*by_law, *(replace(one, certain=one.cause in certain) for one in fits)])
    chosen = choose(ranked, screening)
    small = too_small(ranked, screening)
    if (
        small is None
        and in_doubt(chosen, ranked)
        and top - last.train_log_likelihood > 2.0 * screening.threshold_nats
    ):
        others = rank([*by_law, *_with_straying(data, last, split, near)])
        other = choose(others, screening)
        if other is not None and (chosen is None or other.law is None):
            ranked, chosen = others, other
    return Stage(screening, ranked, chosen, too_small=small)


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
    data = make_data(one.world, split)
    found = fit(data, one.start, names, iterations=turns, colour=last.colour)
    # a law learnt without the step takes it for its own
    if onset_of(one.cause) in AT_ONCE and "arrival" in found.colour:
        own = _with_own_wander(found, split)
        found = own if own.train_log_likelihood > found.train_log_likelihood else found
    return found


def _held_begun_anew(refits: list[tuple[Cause, Fit]], last: Fit, split: Split) -> list[tuple[Cause, Fit]]:
    """The refits, the best of each cause that holds the arm begun on what moves where that explains more, unless it
    explains next to nothing beside the others."""
    most = (
        max((one.train_log_likelihood for _, one in refits), default=last.train_log_likelihood)
        - last.train_log_likelihood
    )
    found = list(refits)
    sizes = {cause.id: cause.holds for cause, _ in refits if cause.holds is not None}
    for holding, size in sizes.items():
        places = [place for place, (cause, _) in enumerate(refits) if cause.id == holding]
        place = max(places, key=lambda place: refits[place][1].train_log_likelihood)
        cause, one = refits[place]
        if one.train_log_likelihood - last.train_log_likelihood < _SHARE_TO_BEGIN_ANEW * most:
            continue
        data = make_data(one.world, split)
        begun = begun_on_what_moves(data, one.vector, size, one.free, last.colour)
        if begun is not None:
            other = fit(data, begun, one.free, iterations=_ITERATIONS_FAR, colour=last.colour)
            found[place] = cause, max(one, other, key=lambda fitted: fitted.train_log_likelihood)
    return found


def _with_straying(data: Data, last: Fit, split: Split, refits: list[tuple[Cause, Fit]]) -> list[Candidate]:
    """The leading candidates once more, what the best of them leaves taken for noise that strays slowly."""
    best = max((one for _, one in refits), key=lambda one: one.train_log_likelihood)
    colour = strayed(make_data(best.world, split), best)
    again = _under(data, last, colour)
    if again is None:
        return []
    found = []
    for cause, one in refits:
        if one.train_log_likelihood - last.train_log_likelihood > 0.3 * (
            best.train_log_likelihood - last.train_log_likelihood
        ):
            other = fit(make_data(one.world, split), one.vector, one.free, iterations=8, colour=colour)
            found.append(_of_fit(cause, other, again, split))
    return found


def _of_law(data: Data, last: Fit, law: LawFound) -> Candidate:
    everywhere = np.ones(len(law.held_out_score), bool)
    return Candidate(
        law.cause, last, law.train_log_likelihood, float(law.held_out_score.sum()),
        _spread(law.held_out_score, everywhere), law.held_out_score, law.values, law, tuple(law.values), law.note,
    )  # fmt: skip


def _of_fit(cause: Cause, refitted: Fit, last: Fit, split: Split) -> Candidate:
    refitted, spread = onset_seen(refitted, cause, split)
    gains = _gain_where_predictable(refitted, last, split)
    values = cause.parameters_of(refitted)
    if "onset_s" in values:
        values["onset_s"] = (values["onset_s"][0], spread)
    return Candidate(
        cause.id,
        refitted,
        refitted.train_log_likelihood - last.train_log_likelihood,
        float(gains[split.held].sum()),
        _spread(gains, split.held),
        gains,
        values,
        None,
        cause.free(refitted.world),
        prior_penalty=cause.prior_penalty(refitted),
        train_blocks=refitted.train_blocks - last.train_blocks,
    )


def _lost(one: Candidate, final: Fit, without: Fit, split: Split) -> float:
    """Held-out nats that go with a finding; all, where it need not show where something is held out: it has an onset,
    by an edge perhaps; or the data show it by themselves; or all blocks together speak for it."""
    held = _gain_where_predictable(final, without, split)
    train = final.train_blocks - without.train_blocks
    anywhere = one.certain or onset_of(CAUSES[one.cause]) is not None or by_all_blocks(held + train)
    return float(held[split.held].sum()) + (float(train.sum()) if anywhere else 0.0)


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
            rest = tuple(name for name in rest if name in world.space.place)
            own = set(cause.free(world)) - set(rest)  # what another finding frees, too, is its own
            neutral = {name: world.space[name].start for name in own}
            start = world.space.with_values(found.final.vector, neutral)
            if cause.id == "second_bending_mode":
                world = variant(world, {"extra_modes": -1})
                start = carried_over(found.final, world)
            names = tuple(dict.fromkeys((*world.baseline_names(), *rest)))
            without = fit(make_data(world, split), start, names, colour=found.final.colour)
            losses.append((_lost(one, found.final, without, split), one, without))
        least, one, without = min(losses, key=lambda loss: loss[0])
        if least > LEAST_HELD_NATS:
            return
        found.findings.remove(one)
        found.final = without
