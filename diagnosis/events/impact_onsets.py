"""Impacts moved to the instant at which the accelerometer first shows them.

A jump of the first mode's phasor tells an impact to a part of a swing. The accelerometer tells it to a sample: it
departs from the model at the impact, and goes on while the higher modes ring that the impact set off. With the impact
at a wrong instant no state of those modes fits, and a second impact is made up where they have died away.
"""

import numpy as np

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.events.impacts import ANEW, WHILE_SOUGHT, pruned, refit_with
from stillarm.diagnosis.fitting.departures import LOUD_OVER_S, loud_at, loud_beside, stretches
from stillarm.diagnosis.fitting.fit import CHANGED_NATS
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.fitting.gains import gain_of

_MADE_UP_PERIODS = 4.0  # after an impact at a wrong instant
_PAIR_PERIODS = 1.5  # apart at most, are two impacts that stand about one
_STROKE_S, _MOST_STROKES = 0.06, 2  # that a stroke is loud, at most; tried about an impact
_SHARPER_S = 0.002  # by less no impact is moved


def with_impacts_at_onsets(last: Fit, split: Split) -> Fit:
    """The fit, or a likelier one with an impact at the onset of the departure about it, and none made up after it."""
    before, tried = last, set[tuple[int, int]]()
    while (moved := _one_moved(last, split, tried)) is not None:
        last = moved
    return last if last is before else pruned(last, split)


def _one_moved(last: Fit, split: Split, tried: set[tuple[int, int]]) -> Fit | None:
    """A fit with the first impact moved that is likelier elsewhere; None where none is. tried: cycles from and to, that
    were no better; adds those of now."""
    per_s = 1.0 / last.world.measured.cycle_s
    reach = _MADE_UP_PERIODS * per_s / last.value("modes.0.frequency_hz")
    for cycle in last.world.impacts:
        onset = _onset(last, cycle)
        for there in [*([] if onset is None else [onset]), *_strokes(last, cycle), *_between(last, cycle)]:
            if any(cycle == old and abs(there - to) < _SHARPER_S * per_s for old, to in tried):
                continue
            tried.add((cycle, there))
            others = (i for i in last.world.impacts if i != cycle and not there < i < there + reach)
            impacts = tuple(sorted({*others, there}))
            quick = refit_with(last, split, impacts, iterations=WHILE_SOUGHT, anew=ANEW)
            if gain_of(quick, last) <= CHANGED_NATS:
                continue
            moved = refit_with(last, split, impacts)  # a quick fit may be anywhere
            if gain_of(moved, last) > CHANGED_NATS:
                return moved
    return None


def _strokes(last: Fit, cycle: int) -> list[int]:
    """The cycles within a swing of an impact at which the accelerometer is struck, and nothing yet stands: of two
    impacts within a swing the phasor puts one where neither was."""
    loud = loud_at(last, "acceleration")
    if loud is None:
        return []
    time, flags = loud
    cycle_s, period = last.world.measured.cycle_s, 1.0 / last.value("modes.0.frequency_hz")
    found = []
    for first, end in stretches(flags):
        middle, lasts = 0.5 * (time[first] + time[end - 1]), time[end - 1] - time[first]
        free = all(abs(middle - i * cycle_s) > _STROKE_S for i in last.world.impacts)
        if lasts < _STROKE_S and abs(middle - cycle * cycle_s) < period and free:
            found.append(round(middle / cycle_s))
    return found[:_MOST_STROKES]


def _between(last: Fit, cycle: int) -> list[int]:
    """The cycle at which the accelerometer departs most between an impact and one that follows within some swings: two
    that cancel stand about one that neither is at."""
    acceleration = last.channel("acceleration")
    after = min((i for i in last.world.impacts if i > cycle), default=None)
    if acceleration is None or after is None:
        return []
    reach = _PAIR_PERIODS / (last.value("modes.0.frequency_hz") * last.world.measured.cycle_s)
    if after - cycle > reach:
        return []
    off = np.abs(acceleration.residual[cycle:after])
    return [cycle + int(np.nanargmax(off))] if np.isfinite(off).any() else []


def _onset(last: Fit, cycle: int) -> int | None:
    """The cycle at which the accelerometer first departs, about an impact, from a model without it: an impact that
    stands too early departs itself from there on. None where it does not, or where the impact is there already."""
    world = last.world
    acceleration = last.channel("acceleration")
    jump = dict.fromkeys(world.space.names(f"jump.{world.impacts.index(cycle) + 1}."), 0.0)
    without = world.predict(world.space.with_values(last.vector, jump)).channels.get("acceleration")
    if acceleration is None or without is None:
        return None
    off = acceleration.residual + acceleration.predicted - without
    known = np.isfinite(off)
    width = round(LOUD_OVER_S / world.measured.cycle_s)
    loud = np.zeros(len(off), bool)
    loud[known] = loud_beside(off[known], acceleration.residual[known], width)
    reach = round(1.0 / (last.value("modes.0.frequency_hz") * world.measured.cycle_s))
    begins = max(cycle - reach, 0)
    first = np.flatnonzero(loud[begins : cycle + reach])
    if not len(first) or first[0] == 0:
        return None
    onset = begins + int(first[0]) + width // 2  # the window reaches back by as much
    return onset if abs(onset - cycle) * world.measured.cycle_s > _SHARPER_S else None
