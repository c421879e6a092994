"""All forms of causes on top of one fit, the best first: fitted quickly from several starts, the best to the end.

The baseline's derivatives are those of the fit so far (the chord method): a further fit works out its own quantities'
alone, and costs a tenth. The best few are polished with all derivatives.
"""

from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.evidence import PRICE_NATS, score
from stillarm.diagnosis.fitting.fitted import Fit, carried_over, make_data
from stillarm.diagnosis.fitting.gains import gain_of
from stillarm.diagnosis.fitting.rest import anything_but_spikes_matters
from stillarm.diagnosis.forms import delay_walk, sensor_walk
from stillarm.diagnosis.forms.catalogue import from_an_onset
from stillarm.diagnosis.forms.cause import Form
from stillarm.diagnosis.physics.computing import OutOfTime, limited_to
from stillarm.diagnosis.physics.copies import shared_out
from stillarm.diagnosis.physics.space import Added
from stillarm.diagnosis.search.begun import Begun, Ground, Pair, ground_of
from stillarm.diagnosis.search.candidates import Candidate, Found, Hint, beside_another
from stillarm.diagnosis.search.carried import hinted
from stillarm.diagnosis.search.convincing import is_course
from stillarm.diagnosis.search.onsets import sized, with_onset
from stillarm.diagnosis.search.refits import (
    FROM_AFAR,
    LOOK,
    begins_afar,
    candidate_of,
    polished,
    refitted,
    throughout,
    to_the_end,
)
from stillarm.diagnosis.search.screen import Scored, screen
from stillarm.diagnosis.search.whitened import Whitened

_Item = TypeVar("_Item")
_Key = TypeVar("_Key")
_POLISHED = 3  # causes
_WALKS: tuple[tuple[Form, str, Callable[[Fit, Fit], bool]], ...] = (
    (
        sensor_walk.IMAGE_WALK,
        sensor_walk.IMAGES,
        partial(sensor_walk.is_foretold, channel=sensor_walk.IMAGES),
    ),
    (sensor_walk.BIAS_WALK, sensor_walk.BIAS, partial(sensor_walk.is_foretold, channel=sensor_walk.BIAS)),
    (delay_walk.FORM, "arrival", delay_walk.is_foretold),
)
"""Each with the channel in which it walks, and with whether another fit foretells what it follows."""
_RIVALS = 5  # candidates that a walk is held against
_WITH_ONSET = 4  # causes that an onset is tried for
LEFT_OUT = "some forms of causes"

SCREENED_NATS = 8.0
"""Below this promise of a score test no fit is begun."""

_STARTS, _MOST_STARTS = 2, 8  # by their scores; with those that the data ask for
_GO_ON = 2  # of a form's starts afar: one for each of two processors
_PROMISING = 0.02  # of the best score: what promises less says more in a later round
_LATER, _PROMISING_LATER = 5, 0.1  # causes begun from an onset at once, at most; as above, of those
_SECOND = 0.5
"""Of the best trial's score, below which no fit is begun from another trial of the same form; of the best of those that
the data ask for, from another one of these."""
_WORTH_A_FIT = 0.1
"""Of the best form's gain: a quick fit is nearly at its end; a later round says more of the rest."""
_QUICK_SHARE, _ENDED_SHARE, _ONSET_SHARE = 0.5, 0.6, 0.5
"""Of the time that is left, what the quick fits may take, those to the end of what these leave, and so on: the best of
few forms says more than quick fits of all, and the most promising go first."""
_IN_REACH = 0.5  # of the leading form's merit, where that leaves nothing that matters
_WORTH_A_SEARCH = 0.03  # the same of a form whose threshold is not yet searched along


@dataclass(frozen=True)
class _Promise:
    """What a quick fit gains: in nats by the log score that makes more of it, and by that of all frequencies alone."""

    begun: Begun
    gain: float
    nats: float


def compared(
    last: Fit, tried: Sequence[Form], split: Split, found: Found
) -> tuple[list[Scored], list[Candidate]]:
    """Each form refitted on top of a fit, and what it is worth; the best first."""
    candidates: list[Candidate] = []
    screening: list[Scored] = []
    try:
        ground = ground_of(last, split)
        if found.hint is not None:
            first = hinted(ground, found.hint.taken, tried)
            candidates += [] if first is None else [first]
            if first is not None and _says_which_are_near(found.hint, first, split):
                tried, far = _near_there(ground, found.hint, tried)
                candidates += far
        white = Whitened(make_data(last.world, split), last, ground.slopes)
        begun, screening = begun_fits(white, tried)
        known = _known(begun, last)

        def judged(
            work: Callable[[Pair], tuple[Begun, Fit | None]], pairs: Sequence[Pair], share: float = 1.0
        ) -> list[Pair]:
            with limited_to(share):
                done = _each(work, pairs, found, [*known, *(one for one, _ in pairs)])
            candidates.extend(candidate_of(ground, pair) for pair in done)
            return done

        with limited_to(_QUICK_SHARE):
            quick = _quick_fits(ground, begun, found, known)
        ended = judged(partial(to_the_end, ground), best_of_each(quick), _ENDED_SHARE)
        near = _in_reach(ended, candidates, split)
        later = judged(partial(with_onset, ground, white), _worth_an_onset(candidates, near), _ONSET_SHARE)
        near = _in_reach([*near, *later], candidates, split)
        at_best = judged(partial(polished, ground), _leading(near, candidates))
        judged(partial(throughout, ground), [pair for pair in at_best if pair[0].form.throughout is not None])
    except OutOfTime:
        found.left_out.append(LEFT_OUT)
    for one in candidates:
        one.fit.world.forget()
    return screening, _without_needless_walks(sorted(candidates, key=lambda one: -one.merit), last)


def _says_which_are_near(hint: Hint, here: Candidate, split: Split) -> bool:
    """Whether a hint's round says of this one which forms may be the best: it leaves nothing that matters here either,
    or it gains as much here, beside no more than the impacts that it bears out."""
    as_much = here.merit > _IN_REACH * hint.taken.merit
    return (hint.struck and as_much) or not anything_but_spikes_matters(here.fit, split)


def _near_there(ground: Ground, hint: Hint, tried: Sequence[Form]) -> tuple[Sequence[Form], list[Candidate]]:
    """The forms that came near a hint where it was found, and the candidates that did not, as they are worth here: what
    gained far less there is not fitted anew."""
    if set(hint.baseline.residuals) != set(ground.last.residuals):  # of the joint alone, which costs little
        return tried, []
    near = {one.cause for one in hint.stage.candidates if one.merit > _IN_REACH * hint.taken.merit}
    far = [one for one in hint.stage.candidates if one.cause not in near and one.law is None]
    there = score(hint.baseline, ground.split)
    return [one for one in tried if one.id in near], beside_another(far, there, ground.score)


def _without_needless_walks(by_merit: Sequence[Candidate], last: Fit) -> list[Candidate]:
    """Candidates without a walk of the images, of a bias or of the delay, if one of those that tell most in its channel
    foretells these as well, whatever else is hidden that gains more elsewhere; of the same cause one that takes no
    course of its own, such as a drift with the path travelled."""
    needless = set()
    for form, channel, is_foretold in _WALKS:
        others = [one for one in by_merit if one.form != form.name and one.merit > PRICE_NATS]
        others.sort(key=lambda one: -one.gains.get(channel, 0.0))
        rivals = [one.fit for one in others[:_RIVALS] if one.cause != form.id or not is_course(one, last)]
        walks = any(one.form == form.name and one.cause == form.id for one in by_merit)
        if walks and any(is_foretold(last, rival) for rival in rivals):
            needless.add((form.id, form.name))
    return [one for one in by_merit if (one.cause, one.form) not in needless]


def _known(begun: Sequence[Begun], last: Fit) -> list[object]:
    """What a fit of a form shares with the fit so far and with other forms."""
    shown = last.predicted
    return [last, last.world, shown.motion, shown.rate_px_s, *begun, *(one.world for one in begun)]


def _each(
    work: Callable[[_Item], tuple[_Key, Fit | None]],
    items: Sequence[_Item],
    found: Found,
    known: Sequence[object],
) -> list[tuple[_Key, Fit]]:
    """The work on each item; what the time did not suffice for is left out, and told. known: as in shared_out."""

    def tried(item: _Item) -> tuple[_Key, Fit | None] | None:
        try:
            return work(item)
        except OutOfTime:
            return None

    done = shared_out(tried, items, known)
    if any(one is None for one in done) and LEFT_OUT not in found.left_out:
        found.left_out.append(LEFT_OUT)
    return [(one[0], one[1]) for one in done if one is not None and one[1] is not None]


def _in_reach(pairs: list[Pair], candidates: Sequence[Candidate], split: Split) -> list[Pair]:
    """The forms that may still be the best: where the leading one leaves nothing that matters, none can gain much more,
    and what gains far less is not worth the time to its end."""
    best = max(candidates, key=lambda one: one.merit, default=None)
    if best is None or anything_but_spikes_matters(best.fit, split):
        return pairs
    merit = {id(one.fit): one.merit for one in candidates}
    return [pair for pair in pairs if merit[id(pair[1])] > _IN_REACH * best.merit]


def _leading(fits: list[Pair], candidates: Sequence[Candidate]) -> list[Pair]:
    """The best form of each of the few causes that may be taken; and where that one is free, the declared one too: by
    the derivatives of a baseline that the cause has bent it may not have got far."""
    merit = {id(one.fit): one.merit for one in candidates}
    best = sorted(fits, key=lambda pair: -merit.get(id(pair[1]), 0.0))
    worth = [pair for pair in best if merit.get(id(pair[1]), 0.0) > PRICE_NATS]
    leading = list(_first_of_each_cause(worth).values())[:_POLISHED]
    free = {one.form.id for one, _ in leading if one.form.added is not None}
    return [*leading, *(pair for pair in worth if pair[0].form.id in free and not pair[0].form.name)]


def _worth_an_onset(candidates: Sequence[Candidate], ended: list[Pair]) -> list[Pair]:
    """A form each of the causes that gain most and may have begun within the recording."""
    merit = {(one.cause, one.form): one.merit for one in candidates}
    by_merit = []
    for one, fitted in sorted(ended, key=lambda pair: -merit.get((pair[0].form.id, pair[0].form.name), 0.0)):
        later = from_an_onset(one.form)
        if later is not None:
            by_merit.append((replace(one, form=later), fitted))
    # what acts in half of the recording alone may do worse than nothing throughout
    by_fit = sorted(by_merit, key=lambda pair: -pair[1].train_log_likelihood)
    half = list(_first_of_each_cause(by_fit).values())[: _WITH_ONSET // 2]
    return list(_first_of_each_cause([*half, *by_merit]).values())[:_WITH_ONSET]


def _first_of_each_cause(pairs: Sequence[Pair]) -> dict[str, Pair]:
    """The first pair of each cause, by cause, in their order."""
    first: dict[str, Pair] = {}
    for pair in pairs:
        first.setdefault(pair[0].form.id, pair)
    return first


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
            if one.nats > max(SCREENED_NATS, _PROMISING_LATER * top) and not enough:
                to_size.append((form, one))
            continue
        least = max(SCREENED_NATS, _PROMISING * top, _SECOND * best.get(id(one.cause), 0.0))
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
    return one.nats / max(top, SCREENED_NATS)


def _quick_fits(
    ground: Ground, begun: Sequence[Begun], found: Found, known: Sequence[object]
) -> list[tuple[_Promise, Fit]]:
    """A quick fit from each start. Of a form that begins afar in several places each of them gets a few steps, and the
    best go on (successive halving: Karnin, Koren and Somekh, ICML 2013): the steps cost most there, and a few tell
    which onset is nearest."""
    afar = [one for one in begun if begins_afar(ground, one)]
    starts = Counter(id(one.form) for one in afar)
    looked_at = {id(one) for one in afar if starts[id(one.form)] > _GO_ON}

    def first(one: Begun) -> tuple[_Promise, Fit | None]:
        return _quickly(ground, one, LOOK if id(one) in looked_at else FROM_AFAR)

    quick = _each(first, begun, found, known)
    further: list[Begun] = []
    gone_on: Counter[int] = Counter()
    for promise, fitted in sorted(quick, key=lambda each: -each[0].gain):
        one = promise.begun
        if id(one) in looked_at and gone_on[id(one.form)] < _GO_ON:
            gone_on[id(one.form)] += 1
            further.append(replace(one, start=fitted.vector))
    return [*quick, *_each(partial(_quickly, ground), further, found, known)]


def _quickly(ground: Ground, one: Begun, from_afar: int = FROM_AFAR) -> tuple[_Promise, Fit | None]:
    """A quick fit without what it shows of the recording, of which a hundred would take a gigabyte.

    Noise that is coloured as what the last fit leaves foretells a large smooth rest so well that to be rid of it gains
    nothing: the log score by frequency, in which the level is learnt anew, has a say too.
    """
    last, fitted = ground.last, refitted(ground, one, from_afar)
    if fitted is None:
        return _Promise(one, 0.0, 0.0), None
    nats = float(score(fitted, ground.split).gain(ground.score).sum())
    gain = max(gain_of(fitted, last), nats)
    one.world.forget()
    return _Promise(one, gain, nats), replace(
        fitted, residuals={}, predicted=replace(last.predicted, channels={})
    )


def best_of_each(quick: list[tuple[_Promise, Fit]]) -> list[Pair]:
    """The best start of each form, without those that explain next to nothing of what the best of their place does."""
    best: dict[tuple[str, str], tuple[_Promise, Fit]] = {}
    for one, fitted in quick:
        key = (one.begun.form.id, one.begun.form.name)
        if key not in best or one.gain > best[key][0].gain:
            best[key] = (one, fitted)
    top = max((one.gain for one, _ in best.values()), default=0.0)
    most = max((one.nats for one, _ in best.values()), default=0.0)
    kept = [found for found in best.values() if _goes_on(found[0], top, most)]
    return [(one.begun, fitted) for one, fitted in sorted(kept, key=lambda found: -found[0].gain)]


def _goes_on(one: _Promise, top: float, most: float) -> bool:
    """Whether a form is fitted to the end. top, most: gain and nats of the best forms. Either may tell: white noise's
    likelihood says so much of a loud line that what bends the images is nothing beside it."""
    form = one.begun.form
    # nor does it say much of a course that steps where it is held out
    if form.added or one.begun.asked:
        return True
    share = _WORTH_A_SEARCH if form.cause.settle else _WORTH_A_FIT
    return one.gain > share * top or one.nats > max(share * most, PRICE_NATS)
