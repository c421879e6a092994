"""Torques that are slower than a block, sought on longer blocks once all that is quicker is in the model.

A block's own initial state takes away what is slower than the block: a constant torque, or gravity on a joint that
turns slowly, is then mistaken for the other or missed. Longer blocks lose less to their states, and what the model
lacks adds up for longer. Other causes are judged on the short ones, where no error of the model adds up; but where
these have asked for a further mode that is slower than a block, which can pass for anything slow, all is judged anew.
"""

from collections.abc import Callable
from dataclasses import replace
from math import exp, inf, pi

import numpy as np

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.driven.fitting.fitting import SEARCH_STEPS, DrivenFit, fit
from stillarm.diagnosis.driven.mechanisms.mechanisms import FORMS, STIFF_JOINT, STRUCTURE, Form
from stillarm.diagnosis.driven.recording.blocks import longer
from stillarm.diagnosis.driven.search.from_start import fitted_from
from stillarm.diagnosis.driven.search.judging import CONVINCES, Tried, judged
from stillarm.diagnosis.driven.search.removal import without_form
from stillarm.diagnosis.driven.search.search import (
    ANOTHER_MODE,
    Round,
    Searched,
    cause_first,
    plainer_first,
    settled,
    tried_forms,
)

_OF_SLOW_TORQUES = ("torque_offset", "gravity_load")
_MOST_ROUNDS = 2  # an offset and gravity


def with_slow_torques(found: Searched, left_s: Callable[[], float] = lambda: inf) -> Searched:
    """What the search found, with what longer blocks say of slow torques in place of what short ones said. The same
    where they say less, lose a cause that was worth more, or where the blocks were held out by somebody."""
    split = longer(found.final.box.split) if not found.final.box.driven.joins else None
    if split is None or left_s() < 0.0:
        return found
    slow_modes = _slow_modes(found)
    kept = [one for one in found.rounds if not _is_slow(one.taken.form)]
    for _ in range(slow_modes):
        kept.remove([one for one in kept if one.taken.form.words == ANOTHER_MODE.words][-1])
    current = _without_slow(found, slow_modes, split)
    rounds: list[Round] = []
    for _ in range(_MOST_ROUNDS + slow_modes):
        tried = tried_forms(current, left_s) if slow_modes else _tried(current, left_s)
        if not tried or tried[0].merit < CONVINCES:
            break
        tried = plainer_first(cause_first(tried))
        rounds.append(Round(current, tuple(tried)))
        current = settled(tried[0].fit)
    causes = [one.taken for one in rounds if one.taken.form.cause != STRUCTURE]
    if not causes:
        return found
    longer_said = replace(found, rounds=(*kept, *rounds), final=current)
    said = [one.taken.merit for one in found.rounds if one.taken.form.cause in _OF_SLOW_TORQUES]
    said += _lost(longer_said, kept)
    return longer_said if max(one.merit for one in causes) >= max(said, default=0.0) else found


def _lost(longer_said: Searched, kept: list[Round]) -> list[float]:
    """What those causes were worth on short blocks that the model of the long ones does as well without. A fit over
    long blocks may end beside the ripple that short ones have found, as its phase adds up an error of the angle."""
    forms, final = [one.taken.form for one in longer_said.rounds], longer_said.final
    lost = []
    for one in (each.taken for each in kept if each.taken.form.cause != STRUCTURE):
        without = without_form(final, one.form, forms, longer_said.start.numbers)
        if judged(one.form, final, without).merit < CONVINCES:
            lost.append(one.merit)
    return lost


def _is_slow(form: Form) -> bool:
    return form.cause in _OF_SLOW_TORQUES or form.words == STIFF_JOINT


def _slow_modes(found: Searched) -> int:
    """How many of the further modes, the last ones, have a period that is longer than a block."""
    box, count = found.final.box, 0
    longest_s = float(np.max(np.diff(box.split.edges_s)))
    while box.modes - count > found.start.box.modes:
        if 2.0 * pi / exp(found.final.numbers[f"log_w_{box.modes - count}"]) < longest_s:
            break
        count += 1
    return count


def _without_slow(found: Searched, slow_modes: int, split: Split) -> DrivenFit:
    """The final model on longer blocks, without the slow torques and modes that short ones have shown."""
    final = found.final
    gone = {name for one in found.rounds if _is_slow(one.taken.form) for name in one.taken.form.numbers}
    box = replace(final.box, split=split, modes=final.box.modes - slow_modes)
    for i in range(box.modes + 1, final.box.modes + 1):
        gone |= {name for name in final.numbers if name.partition(" ")[0].endswith(f"_{i}")}
    numbers = {name: value for name, value in final.numbers.items() if name not in gone}
    free = tuple(one for one in final.free if one not in gone)
    return fit(box, numbers, free, steps=SEARCH_STEPS)


def _tried(current: DrivenFit, left_s: Callable[[], float]) -> list[Tried]:
    """Every slow torque beside what there is, each from all of its starts, best first."""
    forms = [
        one
        for one in FORMS
        if _is_slow(one) and one.fits(current) and not set(one.numbers) <= set(current.free)
    ]
    fits = [
        (form, fitted_from(form, start, current))
        for form in forms
        for start in form.starts(current)
        if left_s() > 0.0
    ]
    return sorted(
        (judged(form, one, current) for form, one in fits if one is not None), key=lambda one: -one.merit
    )
