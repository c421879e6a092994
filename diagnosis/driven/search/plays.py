"""Fits with play, the slowest to simulate: from a few starts, with the sensors on either side of it."""

from collections.abc import Callable
from dataclasses import replace
from math import log

from stillarm.diagnosis.driven.fitting.fitting import SEARCH_STEPS, DrivenFit, fit
from stillarm.diagnosis.driven.mechanisms.gaps import BOUNCE, HARD_PLAY
from stillarm.diagnosis.driven.mechanisms.mechanisms import Form, box_of
from stillarm.diagnosis.driven.search.from_start import LEAST_PART, MOST_PART, fitted_from
from stillarm.diagnosis.driven.search.judging import Tried, judged
from stillarm.diagnosis.driven.search.screen import Screen

_MOST_PLAYS = 3  # starts that are fitted, the best first


def plays(
    form: Form, current: DrivenFit, screen: Screen, left_s: Callable[[], float], least: float
) -> list[Tried]:
    """The best fits with play. Each start's gap is as wide as explains most to first order, against no gap at all.
    least: share of the squared residual below which no start is fitted. On which side of the play each sensor sits is
    chosen by what gains most, and no number: it costs the logarithm of how many ways there are."""
    from_here = box_of(form, current)
    ranked: list[tuple[float, dict[str, float]]] = []
    tried = list(form.starts(current))
    sides = len({(one["on_motor"], one["rate_on_motor"]) for one in tried})
    for start in tried:
        if left_s() > 0.0:
            share, along = screen.share_from(from_here, {**start, "gap": 0.0}, start)
            if along > 0.0:
                ranked.append(
                    (share, {**start, "gap": min(max(along, LEAST_PART), MOST_PART) * start["gap"]})
                )
    ranked.sort(key=lambda one: -one[0])
    starts = [one for share, one in ranked[:_MOST_PLAYS] if share >= least]
    fits = [fitted_from(form, one, current) for one in starts if left_s() > 0.0]
    found = [judged(form, one, current) for one in fits if one is not None]
    found.sort(key=lambda one: -one.merit)
    if found and left_s() > 0.0:  # hard blows part again; small play at rest does not
        best, hard = found[0].fit, replace(form, words=f"{form.words}, teeth part", numbers=HARD_PLAY)
        free = tuple(dict.fromkeys((*best.free, *HARD_PLAY)))
        parts = fit(best.box, {**best.numbers, "bounce": BOUNCE}, free, best.states, steps=SEARCH_STEPS)
        found.append(judged(hard, parts, current))
    return [replace(one, merit=one.merit - log(max(sides, 1))) for one in found]
