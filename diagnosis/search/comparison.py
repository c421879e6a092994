"""All forms of causes on top of one fit, the best first: fitted quickly from several starts, the best to the end.

The baseline's derivatives are those of the fit so far (the chord method): a further fit works out its own quantities'
alone, and costs a tenth. The best few are polished with all derivatives.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.evidence import PRICE_NATS, score
from stillarm.diagnosis.fitting.fitted import Fit, make_data
from stillarm.diagnosis.fitting.gains import gain_of
from stillarm.diagnosis.fitting.rest import anything_but_spikes_matters
from stillarm.diagnosis.forms.catalogue import from_an_onset
from stillarm.diagnosis.forms.cause import Form
from stillarm.diagnosis.physics.computing import OutOfTime, limited_to
from stillarm.diagnosis.physics.copies import shared_out
from stillarm.diagnosis.physics.memory import give_back
from stillarm.diagnosis.search.begun import Begun, Ground, Pair, ground_of
from stillarm.diagnosis.search.candidates import Candidate, Found, Hint, beside_another
from stillarm.diagnosis.search.carried import hinted
from stillarm.diagnosis.search.onsets import with_onset
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
from stillarm.diagnosis.search.screen import Scored
from stillarm.diagnosis.search.starts import begun_fits
from stillarm.diagnosis.search.walks import walks_judged
from stillarm.diagnosis.search.whitened import Whitened

_Item = TypeVar("_Item")
_Key = TypeVar("_Key")
_POLISHED = 3  # causes
_WITH_ONSET = 4  # causes that an onset is tried for
LEFT_OUT = "some forms of causes"

_GO_ON = 2  # of a form's starts afar: one for each of two processors
_WORTH_A_FIT = 0.1
"""Of the best form's gain: a quick fit is nearly at its end; a later round says more of the rest."""
_QUICK_SHARE, _ENDED_SHARE, _ONSET_SHARE = 0.5, 0.6, 0.5
"""Of the time that is left, what the quick fits may take, those to the end of what these leave, and so on: the best of
few forms says more than quick fits of all, and the most promising go first."""
IN_REACH = 0.5  # of the leading form's merit, where that leaves nothing that matters
_WORTH_A_SEARCH = 0.03  # the same of a form whose threshold is not yet searched along


@dataclass(frozen=True)
class _Promise:
    """What a quick fit gains: in nats by the log score that makes more of it, and by that of all frequencies alone."""

    begun: Begun
    gain: float
    nats: float


def compared(
    last: Fit, allowed: Sequence[Form], split: Split, found: Found
) -> tuple[list[Scored], list[Candidate]]:
    """Each form refitted on top of a fit, and what it is worth; the best first."""
    tried = allowed
    candidates: list[Candidate] = []
    screening: list[Scored] = []
    give_back()
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
        give_back()
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
        one.fit.predicted.forget()
    by_merit = sorted(candidates, key=lambda one: -one.merit)
    return screening, walks_judged(by_merit, last, allowed, split)


def _says_which_are_near(hint: Hint, here: Candidate, split: Split) -> bool:
    """Whether a hint's round says of this one which forms may be the best: it leaves nothing that matters here either,
    or it gains as much here, beside no more than the impacts that it bears out."""
    as_much = here.merit > IN_REACH * hint.taken.merit
    return (hint.struck and as_much) or not anything_but_spikes_matters(here.fit, split)


def _near_there(ground: Ground, hint: Hint, tried: Sequence[Form]) -> tuple[Sequence[Form], list[Candidate]]:
    """The forms that came near a hint where it was found, and the candidates that did not, as they are worth here: what
    gained far less there is not fitted anew."""
    if set(hint.baseline.residuals) != set(ground.last.residuals):  # of the joint alone, which costs little
        return tried, []
    near = {one.cause for one in hint.stage.candidates if one.merit > IN_REACH * hint.taken.merit}
    far = [one for one in hint.stage.candidates if one.cause not in near and one.law is None]
    there = score(hint.baseline, ground.split)
    return [one for one in tried if one.id in near], beside_another(far, there, ground.score)


def _known(begun: Sequence[Begun], last: Fit) -> list[object]:
    """What a fit of a form shares with the fit so far and with other forms."""
    return [last, last.world, last.predicted, last.predicted.rate_px_s, *begun, *(one.world for one in begun)]


def _each(
    work: Callable[[_Item], tuple[_Key, Fit | None]],
    items: Sequence[_Item],
    found: Found,
    known: Sequence[object],
) -> list[tuple[_Key, Fit]]:
    """The work on each item; what the time did not suffice for is left out, and told. known: as in shared_out."""

    def tried(item: _Item) -> tuple[_Key, Fit | None] | None:
        try:
            key, fitted = work(item)
        except OutOfTime:
            return None
        if fitted is not None:
            fitted.predicted.forget()
        return key, fitted

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
    return [pair for pair in pairs if merit[id(pair[1])] > IN_REACH * best.merit]


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
