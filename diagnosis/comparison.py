"""All forms of causes on top of one fit, the best first."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

from stillarm.diagnosis.budget import OutOfTime
from stillarm.diagnosis.candidate import Candidate, Found
from stillarm.diagnosis.evidence import score
from stillarm.diagnosis.fit import Fit, Split, make_data, slopes_of
from stillarm.diagnosis.forms import Form, from_an_onset
from stillarm.diagnosis.refits import (
    Begun,
    begun_fits,
    best_of_each,
    polished,
    refitted,
    to_the_end,
    with_onset,
)
from stillarm.diagnosis.rivals import PRICE_NATS, candidate_of
from stillarm.diagnosis.screen import Scored
from stillarm.diagnosis.side_by_side import side_by_side

_Item = TypeVar("_Item")
_Pair = tuple[Begun, Fit | None]

_POLISHED = 3  # causes
_WITH_ONSET = 4  # forms that an onset is tried for
LEFT_OUT = "some forms of causes"


def compared(
    last: Fit, tried: Sequence[Form], split: Split, found: Found
) -> tuple[list[Scored], list[Candidate]]:
    """Each form refitted on top of a fit, and what it is worth; the best first."""
    candidates: list[Candidate] = []
    screening: list[Scored] = []
    try:
        before, data = score(last, split), make_data(last.world, split)
        begun, screening = begun_fits(data, last, tried)
        slopes = slopes_of(last)
        quick = _each(lambda one: (one, refitted(one, last, split, slopes)), begun, found)
        best = best_of_each(quick, last)
        ended = _each(lambda pair: (pair[0], to_the_end(pair[0], pair[1], last, split, slopes)), best, found)
        candidates += [candidate_of(one, fitted, last, before, split) for one, fitted in ended]
        later = _each(
            lambda one: with_onset(one, last, split, slopes), _worth_an_onset(candidates, ended), found
        )
        candidates += [candidate_of(one, fitted, last, before, split) for one, fitted in later]
        best_forms = _leading([*ended, *later], candidates)
        at_best = _each(lambda pair: (pair[0], polished(pair[0], pair[1], last, split)), best_forms, found)
        candidates += [candidate_of(one, fitted, last, before, split) for one, fitted in at_best]
    except OutOfTime:
        found.left_out.append(LEFT_OUT)
    return screening, sorted(candidates, key=lambda one: -one.merit)


def _each(work: Callable[[_Item], _Pair], items: Sequence[_Item], found: Found) -> list[tuple[Begun, Fit]]:
    """The work on each item; what the time did not suffice for is left out, and told."""

    def tried(item: _Item) -> _Pair | None:
        try:
            return work(item)
        except OutOfTime:
            return None

    done = side_by_side(tried, items)
    if any(one is None for one in done) and LEFT_OUT not in found.left_out:
        found.left_out.append(LEFT_OUT)
    return [(one[0], one[1]) for one in done if one is not None and one[1] is not None]


def _leading(fits: list[tuple[Begun, Fit]], candidates: Sequence[Candidate]) -> list[tuple[Begun, Fit]]:
    """The best form of each of the few causes that may be taken."""
    merit = {id(one.fit): one.merit for one in candidates}
    found: dict[str, tuple[Begun, Fit]] = {}
    for one, fitted in sorted(fits, key=lambda pair: -merit.get(id(pair[1]), 0.0)):
        if merit.get(id(fitted), 0.0) > PRICE_NATS and len(found) < _POLISHED:
            found.setdefault(one.form.id, (one, fitted))
    return list(found.values())


def _worth_an_onset(
    candidates: Sequence[Candidate], ended: list[tuple[Begun, Fit]]
) -> list[tuple[Begun, Fit]]:
    """The forms that gain most and may have begun within the recording."""
    merit = {(one.cause, one.form): one.merit for one in candidates}
    found = []
    for one, fitted in sorted(ended, key=lambda pair: -merit.get((pair[0].form.id, pair[0].form.name), 0.0)):
        later = from_an_onset(one.form)
        if later is not None:
            found.append((replace(one, form=later), fitted))
    # what acts in half of the recording alone may do worse than nothing throughout
    by_fit = sorted(found, key=lambda pair: -pair[1].train_log_likelihood)[: _WITH_ONSET // 2]
    by_merit = [pair for pair in found if pair not in by_fit][: _WITH_ONSET - len(by_fit)]
    return [*by_fit, *by_merit]
