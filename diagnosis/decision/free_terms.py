"""The best terms of free form on top of a fit: what a name is held against."""

from collections.abc import Sequence
from dataclasses import replace

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.decision.rival_causes import lost_in_place_of
from stillarm.diagnosis.fitting.evidence import CONVINCING_NATS, PRICE_NATS, foretold, score
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Fit, carried_over, make_data
from stillarm.diagnosis.fitting.gains import free_names
from stillarm.diagnosis.fitting.peaks import residual_peaks
from stillarm.diagnosis.fitting.rest import rest_of
from stillarm.diagnosis.forms.freeform import Free, Group, groups
from stillarm.diagnosis.physics.copies import shared_out
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.search.begun import Ground, ground_of
from stillarm.diagnosis.search.candidates import Candidate
from stillarm.diagnosis.search.whitened import Whitened

_STEPS = 4  # of a fit of free terms: they are linear
_FITTED = 8  # groups of free terms, by a score test: of linear terms it is off by what the baseline's own slopes change
_PEAKS = 3  # of a residual's spectrum, at which a resonance of its own is tried


def best_free(last: Fit, split: Split, own: Sequence[str] = (), others: Sequence[Group] = ()) -> Free | None:
    """The group of free terms that adds most to a fit's log score, of those that tell something of a channel in which a
    rest matters, or of one of `own`: what rings in an accelerometer by less than anyone would act on is no rival of a
    clock that was set. others: tried too, such as a resonance that shows only where the arm's own vibration is
    explained."""
    peaks: list[float] = []
    for seen in residual_peaks(last).values():
        peaks += [hz for hz in seen[:_PEAKS] if all(abs(hz / one - 1.0) > 0.02 for one in peaks)]
    kinds = (*groups(peaks), *others)
    ground = ground_of(last, split)
    promising = sorted(zip(_promises(ground, kinds), range(len(kinds)), strict=True), reverse=True)[:_FITTED]
    begun = [
        (kinds[place], world)
        for nats, place in promising
        if nats > 0.0 and (world := kinds[place].world(last)) is not None
    ]
    found = shared_out(
        lambda one: _with_free(ground, *one, last),
        begun,
        [one for group, world in begun for one in (group, world)],
    )
    matters = {*own, *(name for name in last.residuals if not rest_of(last, name, split).immaterial)}
    telling = [one for one in found if any(one.gains[name] > CONVINCING_NATS for name in matters)]
    best = max(telling, key=lambda one: one.merit, default=None)
    if best is None or best.merit <= 0.0:
        return None
    return max(best, _of_its_own_state(ground, best), key=lambda one: one.merit)


def beside_the_others(
    free: Free, first: Candidate, others: Sequence[Candidate], final: Fit, split: Split
) -> Free:
    """Free terms in the place of a finding, beside what was found after it: what both leave is then told by the same. A
    group that tells a little of everything is else worth more than the first of two causes. merit: as many nats off the
    finding's as the recording is told worse so. others: found beside it; final: the fit of all."""
    lost = lost_in_place_of(first, free.fit, others, final, split)
    spared = PRICE_NATS * (len(first.free) - len(free.fit.world.added[-1].amounts))
    return replace(free, merit=first.merit - lost + spared)


def _of_its_own_state(ground: Ground, best: Free) -> Free:
    """Free terms once more, over the state that the arm has beside them: that of a fit which had to make up for what
    they tell is a wrong one."""
    last, data = ground.last, make_data(ground.last.world, ground.split)
    without = fit(data, carried_over(best.fit, last.world), (), iterations=0, colour=last.colour)
    world = best.group.world(without)
    return best if world is None else _with_free(ground, best.group, world, without)


def _promises(ground: Ground, kinds: Sequence[Group]) -> list[float]:
    """Nats that a score test foretells of each group; none of one that is not seen."""
    last = ground.last
    white = Whitened(make_data(last.world, ground.split), last, ground.slopes)

    def promise(group: Group) -> float:
        added = group.added(last)
        return white.promise(added.columns) if added is not None else 0.0

    return shared_out(promise, kinds)


def _with_free(ground: Ground, group: Group, world: World, begun: Fit) -> Free:
    """A group on top of a fit. begun: where it begins."""
    added, last, split = world.added[-1], ground.last, ground.split
    names = free_names(last, world, added.amounts)
    fitted = fit(
        make_data(world, split),
        carried_over(begun, world),
        names,
        iterations=_STEPS,
        colour=last.colour,
        known=ground.slopes,
    )
    after = score(fitted, split)
    nats, held = after.gain(ground.score), foretold(fitted, ground.score, split, after)
    merit = min(
        float(nats.sum()) - PRICE_NATS * len(added.amounts), split.blocks_per_held * float(held.sum())
    )
    gains = after.gains(ground.score)
    return Free(group, merit, max(gains, key=lambda name: gains[name]), fitted, gains)
