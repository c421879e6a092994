"""Where the fits of a comparison begin: the best trials of each form by a score test, and what the data ask for."""

from collections import defaultdict
from collections.abc import Sequence

from stillarm.diagnosis.fitting.fitted import Fit, carried_over
from stillarm.diagnosis.forms.catalogue import from_an_onset
from stillarm.diagnosis.forms.cause import Form
from stillarm.diagnosis.physics.copies import shared_out
from stillarm.diagnosis.physics.space import Added
from stillarm.diagnosis.search.begun import Begun
from stillarm.diagnosis.search.onsets import sized
from stillarm.diagnosis.search.screen import Scored, screen
from stillarm.diagnosis.search.whitened import Whitened

_SCREENED_NATS = 8.0
"""Below this promise of a score test no fit is begun."""

_STARTS, _MOST_STARTS = 2, 8  # by their scores; with those that the data ask for
_PROMISING = 0.02  # of the best score: what promises less says more in a later round
_LATER, _PROMISING_LATER = 5, 0.1  # causes begun from an onset at once, at most; as above, of those
_SECOND = 0.5
"""Of the best trial's score, below which no fit is begun from another trial of the same form; of the best of those that
the data ask for, from another one of these."""


def begun_fits(white: Whitened, tried: Sequence[Form]) -> tuple[list[Begun], list[Scored]]:
    """Where fits begin: the best trials of each form by a score test, and those that the data ask for."""
    last = white.last
    by_cause = {id(one.cause): one for one in tried}
    later = {id(one.cause): from_an_onset(one) for one in tried if one.added is None}
    causes = [one.cause for one in tried if one.added is None]
    screening = screen(white, causes, lambda cause: later[id(cause)] is not None)
    begun: list[Begun] = []
    to_size: list[tuple[Form, Scored]] = []
    count: dict[int, int] = defaultdict(int)
    best: dict[int, float] = {}
    best_asked: dict[int, float] = {}
    top = max((one.nats for one in screening), default=0.0)

    for one in screening:
        form = later[id(one.cause)]
        if one.begins_s is not None and form is not None:
            enough = len({each.id for each, _ in to_size} | {form.id}) > _LATER
            if one.nats > max(_SCREENED_NATS, _PROMISING_LATER * top) and not enough:
                to_size.append((form, one))
            continue
        least = max(_SCREENED_NATS, _PROMISING * top, _SECOND * best.get(id(one.cause), 0.0))
        if not one.trial.asked and (one.nats < least or count[id(one.cause)] >= _STARTS):
            continue
        # from where they begin each step works out all derivatives anew: of those, what is half as good is not tried
        if one.trial.asked and one.nats < _SECOND * best_asked.setdefault(id(one.cause), one.nats):
            continue
        best.setdefault(id(one.cause), one.nats)
        count[id(one.cause)] += 1
        if count[id(one.cause)] > _MOST_STARTS:
            continue
        form = by_cause[id(one.cause)]
        begun.append(Begun(form, one.world, one.start, one.trial.asked, _share_of(top, one)))
    for further, terms in _terms_of(last, tried):
        if terms:
            world = last.world.changed(added=(*last.world.added, *terms))
            begun.append(Begun(further, world, carried_over(last, world)))

    def sets_in(item: tuple[Form, Scored]) -> Begun:
        form, one = item
        return Begun(form, one.world, sized(white, one, form), promised=_share_of(top, one))

    known = [part for form, one in to_size for part in (form, one.world)]
    return [*begun, *shared_out(sets_in, to_size, known)], screening


def _terms_of(last: Fit, tried: Sequence[Form]) -> list[tuple[Form, tuple[Added, ...]]]:
    """The forms that need terms of their own, in order, each with these. What a law says of a fit is remembered by
    this process, which works it out."""
    further = [(one, one.added) for one in tried if one.added is not None]
    others = [added for one, added in further if one.nats_of is None]
    of_others = iter(shared_out(lambda added: added(last), others))
    return [(one, next(of_others) if one.nats_of is None else added(last)) for one, added in further]


def _share_of(top: float, one: Scored) -> float:
    """What a trial promises, over the most that any does."""
    return one.nats / max(top, _SCREENED_NATS)
