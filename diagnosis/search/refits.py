"""A form fitted on top of a fit: quickly, to the end, polished; and what it is worth."""

from dataclasses import replace
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.evidence import PRICE_NATS, Score, foretold, score
from stillarm.diagnosis.fitting.fit import Slopes, fit
from stillarm.diagnosis.fitting.fitted import Data, Fit, make_data
from stillarm.diagnosis.fitting.gains import free_names, gain_of, settled_nats
from stillarm.diagnosis.search.begun import Begun
from stillarm.diagnosis.search.candidates import Candidate
from stillarm.diagnosis.search.onsets import with_onset_settled

Array = NDArray[np.float64]

QUICK, _FULL = 4, 12  # steps of a fit
_MOST_TRIALS = 40  # of a search along a quantity
_QUICK_SETTLED = 1.0  # nats: of a quick fit, a third of what a number costs


def refitted(one: Begun, last: Fit, split: Split, slopes: Slopes) -> Fit | None:
    names = free_names(last, one.world, one.form.cause.free(one.world))
    data = make_data(one.world, split)
    fitted = fit(
        data,
        one.start,
        names,
        iterations=QUICK,
        colour=last.colour,
        known=slopes,
        settled_nats=_QUICK_SETTLED,
    )
    return fitted if one.form.cause.possible(fitted) else None


def to_the_end(one: Begun, fitted: Fit, last: Fit, split: Split, slopes: Slopes) -> Fit | None:
    """All quantities at their best: thresholds and onsets by a search along them, then the rest."""
    data = make_data(one.world, split)
    if one.form.cause.settle:
        fitted = _settled(one, fitted, last, data, slopes)
    settled = settled_nats(fitted, last)
    ended = fit(
        data,
        fitted.vector,
        fitted.free,
        iterations=_FULL,
        colour=last.colour,
        known=slopes,
        settled_nats=settled,
    )
    return ended if one.form.cause.possible(ended) else None


def polished(one: Begun, fitted: Fit, last: Fit, split: Split, slopes: Slopes) -> Fit:
    """The same with all derivatives worked out where it is, and an onset sought to the end."""
    data = make_data(one.world, split)
    if one.form.begins is not None:
        fitted = with_onset_settled(one.form.begins, fitted, last, data, slopes)
    settled = settled_nats(fitted, last)
    return fit(data, fitted.vector, fitted.free, iterations=_FULL, colour=last.colour, settled_nats=settled)


def throughout(one: Begun, fitted: Fit, last: Fit, split: Split, slopes: Slopes) -> tuple[Begun, Fit]:
    """A form with an onset fitted without, from where that one has ended: its search went on from the fit without, and
    what a fit gains by going on is no onset's."""
    begins, form = one.form.begins, one.form.throughout
    assert begins is not None and form is not None
    data, space = make_data(one.world, split), one.world.space
    start = space.with_values(fitted.vector, {begins: space[begins].start})
    whole = fit(data, start, fitted.free, iterations=QUICK, colour=last.colour, known=slopes)
    return replace(one, form=form), whole


def _settled(one: Begun, best: Fit, last: Fit, data: Data, slopes: Slopes) -> Fit:
    """Quantities without a smooth derivative, searched along with halving steps, all else following."""
    for name, first in one.form.cause.settle.items():
        onset = "onset" in name
        step = first * (1.0 if onset else max(abs(best.value(name)), 1e-3) * 10.0)
        least = 4.0 * best.world.measured.cycle_s if onset else 0.02 * step
        names = [each for each in best.free if each != name]
        trials = 0
        while step > least and trials < _MOST_TRIALS:
            moved = False
            for sign in (1.0, -1.0):
                trials += 1
                start = best.world.space.with_values(best.vector, {name: best.value(name) + sign * step})
                trial = fit(data, start, names, iterations=1, colour=last.colour, known=slopes)
                if gain_of(trial, best) > settled_nats(best, last):
                    best, moved = replace(trial, free=best.free), True
                    break
            if not moved:
                step *= 0.4
    return best


def candidate_of(one: Begun, fitted: Fit, last: Fit, before: Score, split: Split) -> Candidate:
    after = score(fitted, split)
    nats, held = after.gain(before), foretold(fitted, before, split, after)
    own = one.form.cause.free(fitted.world)
    values = one.form.cause.parameters_of(fitted)
    merit = (
        float(nats.sum())
        - PRICE_NATS * (len(own) + (2 if one.form.begins else 0))
        - one.form.cause.prior_penalty(fitted)
    )
    if one.form.nats_of is not None:
        merit = one.form.nats_of(last)
    elif one.form.added is not None:  # of many amounts, which fit anything: by what is foretold
        merit = min(merit, split.blocks_per_held * float(held.sum()))
    return Candidate(
        one.form.id, fitted, float(held.sum()), float(held.std(ddof=1) * sqrt(len(held))), values, None, own,
        form=one.form.name,
        begins=one.form.begins, merit=merit, nats=nats,
        begins_s=fitted.value(one.form.begins) if one.form.begins else None,
        parameters_of=one.form.cause.parameters_of,
        gains=after.gains(before),
    )  # fmt: skip
