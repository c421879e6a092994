"""Impacts moved to the instant at which the accelerometer first shows them.

A jump of the first mode's phasor tells an impact to a part of a swing. The accelerometer tells it to a sample: it
departs from the model at the impact, and goes on while the higher modes ring that the impact set off. With the impact
at a wrong instant no state of those modes fits, and a second impact is made up where they have died away.
"""

from collections.abc import Sequence

import numpy as np

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.events.impact_departure import departs_at
from stillarm.diagnosis.events.impacts import ANEW, WHILE_SOUGHT, pruned, refit_with
from stillarm.diagnosis.fitting.departures import loud_at, stretches
from stillarm.diagnosis.fitting.fit import CHANGED_NATS
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.fitting.gains import gain_of
from stillarm.diagnosis.physics.copies import shared_out

_Move = tuple[int, int]
"""Cycle of an impact, and the cycle to which it is moved."""

_MADE_UP_PERIODS = 4.0  # after an impact at a wrong instant
_PAIR_PERIODS = 1.5  # apart at most, are two impacts that stand about one
_STROKE_S, _MOST_STROKES = 0.06, 2  # that a stroke is loud, at most; tried about an impact
_SHARPER_S = 0.002  # by less no impact is moved


def with_impacts_at_onsets(last: Fit, split: Split) -> Fit:
    """The fit, or a likelier one with an impact at the onset of the departure about it, and none made up after it."""
    before, tried = last, set[_Move]()
    while (moved := _likelier_elsewhere(last, split, tried)) is not None:
        last = moved
    return last if last is before else pruned(last, split)


def _likelier_elsewhere(last: Fit, split: Split, tried: set[_Move]) -> Fit | None:
    """A likelier fit with impacts moved that are far from each other, or else with one; None where none is. tried:
    cycles from and to, that were no better; adds those of now."""
    places = _to_try(last, tried)
    gains = shared_out(lambda place: gain_of(_moved(last, split, [place], quickly=True), last), places)
    tried |= set(places)
    better = [place for place, gain in zip(places, gains, strict=True) if gain > CHANGED_NATS]
    together = _apart(better, last)
    # a quick fit may be anywhere
    for moves in ([together] if len(together) > 1 else []) + [[place] for place in better]:
        moved = _moved(last, split, moves)
        if gain_of(moved, last) > CHANGED_NATS:
            tried -= {place for place in better if place not in moves}
            return moved
    return None


def _to_try(last: Fit, tried: set[_Move]) -> list[_Move]:
    """Where each impact may have been instead, but for what was tried."""
    near = _SHARPER_S / last.world.measured.cycle_s
    places: list[_Move] = []
    for cycle in last.world.impacts:
        onset = _onset(last, cycle)
        for there in [*([] if onset is None else [onset]), *_strokes(last, cycle), *_between(last, cycle)]:
            if not any(cycle == old and abs(there - to) < near for old, to in (*tried, *places)):
                places.append((cycle, there))
    return places


def _made_up_over(last: Fit) -> float:
    """Cycles after an impact at a wrong instant, in which another may have been made up."""
    return _MADE_UP_PERIODS / (last.world.measured.cycle_s * last.value("modes.0.frequency_hz"))


def _apart(better: Sequence[_Move], last: Fit) -> list[_Move]:
    """Of the moves that gain, the first of each impact, without those near an impact moved before."""
    reach, chosen = _made_up_over(last), list[_Move]()
    for cycle, there in better:
        if all(abs(one - other) > reach for one in (cycle, there) for move in chosen for other in move):
            chosen.append((cycle, there))
    return chosen


def _moved(last: Fit, split: Split, moves: Sequence[_Move], quickly: bool = False) -> Fit:
    """The fit with these impacts moved, and without those made up after them."""
    reach, impacts = _made_up_over(last), set(last.world.impacts)
    for cycle, there in moves:
        impacts = {i for i in impacts if i != cycle and not there < i < there + reach} | {there}
    if quickly:
        return refit_with(last, split, tuple(sorted(impacts)), iterations=WHILE_SOUGHT, anew=ANEW)
    return refit_with(last, split, tuple(sorted(impacts)))


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
    """The cycle at which the accelerometer first departs about an impact; None where it does not, or where the impact
    is there already."""
    onset = departs_at(last, cycle)
    sharper = onset is not None and abs(onset - cycle) * last.world.measured.cycle_s > _SHARPER_S
    return onset if sharper else None
