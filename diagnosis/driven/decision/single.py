"""One cause in the place of two: a fuller form of one that explains what both do is likelier than both at once.

Friction that is larger one way is the same equation as plain friction with a smaller constant torque; friction that is
larger at rest is much like plain friction with one that grows otherwise with the velocity. A search that takes the
plainest causes first ends with two. The second of them has to win its odds against the fuller form of the other.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from math import inf

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit
from stillarm.diagnosis.driven.mechanisms.mechanisms import FORMS, STRUCTURE, Form
from stillarm.diagnosis.driven.search.from_start import fitted_from
from stillarm.diagnosis.driven.search.judging import (
    BESIDE_SHARE,
    CONVINCES,
    HELD_OUT_TIMES,
    PRICE,
    gains,
    judged,
)
from stillarm.diagnosis.driven.search.removal import without_form
from stillarm.diagnosis.driven.search.search import Round, Searched, holds_in

_MEAN, _BY_DIRECTION = "coulomb", "coulomb_difference"


def one_for_two(found: Searched, left_s: Callable[[], float] = lambda: inf) -> Searched:
    """What the search found, with one cause in place of two where a fuller form of it does as well."""
    taken = [
        one.taken.form
        for one in found.rounds
        if one.taken.form.cause != STRUCTURE and not one.taken.form.play
    ]

    @cache
    def worth(place: int) -> float:
        return _worth(found, taken[place])

    for i, plain in enumerate(taken):
        fuller_forms = _fuller(plain, found.final)
        for j, other in enumerate(taken):
            if other.cause == plain.cause or not fuller_forms:
                continue
            if worth(j) < BESIDE_SHARE * worth(i):
                continue  # it would not be told beside the other
            for fuller in fuller_forms:
                if left_s() < 0.0:
                    return found
                single = _fitted(found, plain, fuller, other)
                if single is not None and _does_as_well(single, found.final, plain, fuller, other):
                    return replace(found, rounds=_rounds(found, plain, fuller, other), final=single)
    return found


def _fuller(plain: Form, final: DrivenFit) -> list[Form]:
    """The forms that hold a plainer one, where the recording can show them."""
    return [one for one in FORMS if not one.hidden and holds_in(plain, one) and one.fits(final)]


def _worth(found: Searched, form: Form) -> float:
    """What the final model loses without a form."""
    forms = [one.taken.form for one in found.rounds]
    return judged(form, found.final, without_form(found.final, form, forms, found.start.numbers)).merit


def _fitted(found: Searched, plain: Form, fuller: Form, other: Form) -> DrivenFit | None:
    """The final model with the fuller form, and without the other cause."""
    forms = [one.taken.form for one in found.rounds]
    base = without_form(found.final, other, forms, found.start.numbers)
    starts = [*fuller.starts(base), *_either_way(found.final, plain, fuller)]
    fits = [fitted_from(fuller, start, base) for start in starts]
    sound = [one for one in fits if one is not None]
    return max(sound, key=lambda one: float(one.whole.sum()), default=None)


def _either_way(final: DrivenFit, plain: Form, fuller: Form) -> Iterator[dict[str, float]]:
    """Starts of friction by direction, half larger forward and backward: of the wrong one a fit ends where there is no
    friction one way, and does not return."""
    if _BY_DIRECTION in fuller.numbers and plain.numbers == (_MEAN,):
        for share in (0.5, -0.5):
            yield {_MEAN: final.numbers[_MEAN], _BY_DIRECTION: share * final.numbers[_MEAN]}


def _does_as_well(single: DrivenFit, both: DrivenFit, plain: Form, fuller: Form, other: Form) -> bool:
    """Whether the second cause fails to win its odds against the fuller form of the first."""
    gained, held = gains(other, both, single)
    more = other.price - (fuller.price - plain.price)
    return min(gained, HELD_OUT_TIMES * held) - PRICE * more < CONVINCES


def _rounds(found: Searched, plain: Form, fuller: Form, other: Form) -> tuple[Round, ...]:
    """The rounds with the fuller form in place of the plain one, and without the other cause's."""
    rounds = []
    for one in found.rounds:
        form = one.taken.form
        if form is other:
            continue
        first = replace(one.taken, form=fuller) if form is plain else one.taken
        rounds.append(Round(one.before, (first, *one.tried[1:])))
    return tuple(rounds)
