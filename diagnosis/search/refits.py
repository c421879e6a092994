"""A form fitted on top of a fit: quickly, to the end, polished; and what it is worth."""

from dataclasses import replace
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.fitting.evidence import PRICE_NATS, foretold, score
from stillarm.diagnosis.fitting.fit import Slopes, fit
from stillarm.diagnosis.fitting.fitted import Data, Fit, make_data
from stillarm.diagnosis.fitting.gains import free_names, gain_of, settled_nats
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.search.begun import Begun, Ground, Pair
from stillarm.diagnosis.search.candidates import Candidate
from stillarm.diagnosis.search.onsets import with_onset_settled

Array = NDArray[np.float64]

QUICK = 4  # steps of a fit
TO_REST = 40
"""Of a fit that is to settle, at most: what an impact sets off in modes that the images alone show is told by few of
them, so that such a fit goes along a valley for thirty steps."""
_MOST_TRIALS = 40  # of a search along a quantity
_AFAR = 0.003  # of the first mode's frequency: within 16 swings, which ring on at 1 % of damping, a third of a radian
FROM_AFAR, LOOK = 8, 2  # steps of a quick fit that begins there, and of a first look at several
_MUCH = 0.5  # of what a score test promises of any form
_QUICK_SETTLED = 1.0  # nats: of a quick fit, a third of what a number costs


def refitted(ground: Ground, one: Begun, from_afar: int = FROM_AFAR) -> Fit | None:
    """A form fitted quickly; None where what comes out is not possible. With derivatives of its own where those of the
    ground lead astray: what is promised much is far from there, where the images' noise is little. from_afar: steps
    with such derivatives, at most."""
    known = _slopes_at(ground, one.world, one.start)
    fitted = _fitted_from(ground, one, known, from_afar)
    if known is not None and one.promised > _MUCH and gain_of(fitted, ground.last) < 0.0:
        fitted = _fitted_from(ground, one, None, from_afar)
    return fitted if one.form.cause.possible(fitted) else None


def begins_afar(ground: Ground, one: Begun) -> bool:
    """Whether each step of a form's quick fit works out all derivatives anew, which costs ten times as much."""
    return _slopes_at(ground, one.world, one.start) is None


def _fitted_from(ground: Ground, one: Begun, known: Slopes | None, from_afar: int) -> Fit:
    """A quick fit from where a form begins, by known derivatives or by its own."""
    return fit(
        make_data(one.world, ground.split),
        one.start,
        free_names(ground.last, one.world, one.form.cause.free(one.world)),
        iterations=from_afar if known is None else QUICK,
        colour=ground.last.colour,
        known=known,
        settled_nats=_QUICK_SETTLED,
    )


def _slopes_at(ground: Ground, world: World, vector: Array) -> Slopes | None:
    """The ground's derivatives, where they hold at a vector of a world; None where the arm swings at another frequency
    there."""
    name = "modes.0.frequency_hz"
    hz = float(vector[world.space.place[name]])
    return None if abs(hz / ground.last.value(name) - 1.0) > _AFAR else ground.slopes


def to_the_end(ground: Ground, pair: Pair) -> tuple[Begun, Fit | None]:
    """All quantities at their best: thresholds and onsets by a search along them, then the rest."""
    one, fitted = pair
    data = make_data(one.world, ground.split)
    if one.form.cause.settle:
        fitted = _settled(ground, one, fitted, data)
    ended = fit(
        data,
        fitted.vector,
        fitted.free,
        colour=ground.last.colour,
        known=_slopes_at(ground, fitted.world, fitted.vector),
        settled_nats=settled_nats(fitted, ground.last),
    )
    return one, ended if one.form.cause.possible(ended) else None


def polished(ground: Ground, pair: Pair, steps: int = TO_REST) -> Pair:
    """The same with all derivatives worked out where it is, in so many steps at most, and an onset sought to the
    end."""
    (one, fitted), last = pair, ground.last
    data = make_data(one.world, ground.split)
    if one.form.begins is not None:
        fitted = with_onset_settled(ground, one.form.begins, fitted, data)
    settled = settled_nats(fitted, last)
    ended = fit(data, fitted.vector, fitted.free, iterations=steps, colour=last.colour, settled_nats=settled)
    return one, ended


def throughout(ground: Ground, pair: Pair) -> Pair:
    """A form with an onset fitted without, from where that one has ended: its search went on from the fit without, and
    what a fit gains by going on is no onset's."""
    one, fitted = pair
    begins, form = one.form.begins, one.form.throughout
    assert begins is not None and form is not None
    data, space = make_data(one.world, ground.split), one.world.space
    start = space.with_values(fitted.vector, {begins: space[begins].start})
    whole = fit(data, start, fitted.free, iterations=QUICK, colour=ground.last.colour, known=ground.slopes)
    return replace(one, form=form), whole


def _settled(ground: Ground, one: Begun, best: Fit, data: Data) -> Fit:
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
                trial = fit(data, start, names, iterations=1, colour=ground.last.colour, known=ground.slopes)
                if gain_of(trial, best) > settled_nats(best, ground.last):
                    best, moved = replace(trial, free=best.free), True
                    break
            if not moved:
                step *= 0.4
    return best


def candidate_of(ground: Ground, pair: Pair) -> Candidate:
    """What a form is worth on top of the fit beneath it."""
    (one, fitted), split, before = pair, ground.split, ground.score
    after = score(fitted, split)
    nats, held = after.gain(before), foretold(fitted, before, split, after)
    own = one.form.cause.free(fitted.world)
    values = one.form.cause.parameters_of(fitted)
    merit = (
        float(nats.sum())
        - PRICE_NATS * (len(own) + (2 if one.form.begins else 0))
        - one.form.cause.prior_penalty(fitted)
    )
    if one.form.nats_of is not None:  # a law of all blocks alike
        merit = one.form.nats_of(ground.last)
        nats = np.full(len(nats), merit / len(nats))
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
