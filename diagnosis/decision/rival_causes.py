"""The causes that a finding is held against: which of them these data do not tell from it."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.evidence import CONVINCING_NATS, score
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Fit, carried_over, make_data
from stillarm.diagnosis.physics.computing import OutOfTime
from stillarm.diagnosis.physics.copies import shared_out
from stillarm.diagnosis.search.candidates import Candidate, Found, Stage, explains_the_same

ODDS_NATS = 3.0
"""Odds of 20 to 1 (contract.md)."""
_TIE = 0.02  # of a finding's nats: a rival that lacks less is as good, as no formula is quite the true one


def beside_what_followed(found: Found, split: Split) -> None:
    """Give each finding's nearest rivals the merits that they have beside what was found after it, as far as the time
    goes.

    A finding is taken while that is untold, and what is untold may hide how two causes differ: where a sensor lags, a
    drive that lags and one that waits look alike.
    """
    with suppress(OutOfTime):
        for number, one in enumerate(found.taken[:-1]):
            stage, near = stage_of(found, one), class_of(found, one)
            rivals = [
                each
                for each in stage.candidates
                if each.cause in near and not changes_structure(each.fit, one.fit)
            ]
            merits = _merits_beside(one, found.taken[number + 1 :], rivals, found.final, split)
            anew = dict(zip(rivals, merits, strict=True))
            stage.candidates = [replace(each, merit=anew.get(each, each.merit)) for each in stage.candidates]


def _merits_beside(
    one: Candidate, after: Sequence[Candidate], rivals: Sequence[Candidate], final: Fit, split: Split
) -> list[float]:
    """Merit of each rival in the place of a finding. after: what was found after that; final: the fit of all."""

    def merit(rival: Candidate) -> float:
        cost = float(rival.nats.sum()) - rival.merit
        return float(one.nats.sum()) - lost_in_place_of(one, rival.fit, after, final, split) - cost

    return shared_out(merit, rivals)


def lost_in_place_of(
    one: Candidate, instead: Fit, others: Sequence[Candidate], final: Fit, split: Split
) -> float:
    """Nats by which the recording is told worse with what another fit has in the place of a finding, beside what was
    found after that. instead: on top of what the finding was taken on; others: found beside it; final: the fit of
    all."""
    followed = final.world.added[len(one.fit.world.added) :]
    world = final.world.changed(added=(*instead.world.added, *followed))
    values = {name: final.value(name) for each in others for name in each.free if name in world.space.place}
    values |= {each.begins: final.value(each.begins) for each in others if each.begins is not None}
    # impacts that the findings made needless are none of it
    own = [name for name in instead.free if name in world.space.place]
    names = tuple(dict.fromkeys((*own, *(name for each in others for name in each.free if name in values))))
    start = world.space.with_values(carried_over(instead, world), values)
    fitted = fit(make_data(world, split), start, names, colour=final.colour)
    return float(score(final, split).gain(score(fitted, split)).sum())


def changes_structure(one: Fit, before: Fit) -> bool:
    """Whether a fit has modes of its own, or another kind of play: no vector of the world before holds the rest."""
    now, then = one.world, before.world
    return now.extra_modes != then.extra_modes or now.behind_encoder != then.behind_encoder


def runner_up(found: Found, one: Candidate) -> Candidate | None:
    """The best other cause when a finding was taken."""
    others = [
        each
        for each in stage_of(found, one).candidates
        if each.cause != one.cause and each.law is None and explains_the_same(each, one)
    ]
    return max(others, key=lambda each: each.merit, default=None) if one.law is None else None


def class_of(found: Found, one: Candidate) -> list[str]:
    """Other causes that these data do not tell from a finding at odds of 20 to 1."""
    if one.law is not None:
        return []
    near = []
    for each in stage_of(found, one).candidates:
        if each.cause == one.cause or each.law is not None or not explains_the_same(each, one):
            continue
        if one.merit - each.merit < max(ODDS_NATS, _TIE * one.merit) and each.merit > CONVINCING_NATS:
            near.append(each.cause)
    return near


def stage_of(found: Found, one: Candidate) -> Stage:
    """The round in which a finding was taken."""
    return next(stage for stage in found.stages if stage.taken is one)
