"""Random walks among the candidates of a comparison: which of them stand, and in the place of what.

A walk goes anywhere, so that it takes what a few numbers foretell; and its merit is of another kind than the log score,
by which all other forms are judged (sensor_walk.py).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from stillarm.common.causes import CAUSES as DECLARED
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.evidence import PRICE_NATS
from stillarm.diagnosis.fitting.fitted import Fit, make_data
from stillarm.diagnosis.forms import delay_walk, sensor_walk
from stillarm.diagnosis.forms.cause import Form
from stillarm.diagnosis.physics.computing import OutOfTime
from stillarm.diagnosis.physics.copies import shared_out
from stillarm.diagnosis.search.begun import Begun, ground_of
from stillarm.diagnosis.search.candidates import Candidate
from stillarm.diagnosis.search.convincing import is_course
from stillarm.diagnosis.search.refits import refitted
from stillarm.diagnosis.search.starts import begun_fits
from stillarm.diagnosis.search.whitened import Whitened

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
_BESIDE = 4  # starts of fits beside the one of these that tells most, by their promise


def walks_judged(
    by_merit: Sequence[Candidate], last: Fit, tried: Sequence[Form], split: Split
) -> list[Candidate]:
    """Candidates, the best first, without needless walks; a walk that stands takes the place of its cause's courses.
    last: the fit on top of which they are; tried: forms that may be named beside one of them."""
    kept = list(by_merit)
    for form, channel, is_foretold in _WALKS:
        walk = next((one for one in kept if (one.cause, one.form) == (form.id, form.name)), None)
        if walk is None:
            continue
        telling = _telling_most(kept, walk, channel)
        rivals = [one.fit for one in telling[:_RIVALS] if one.cause != form.id or not is_course(one, last)]
        needless = any(is_foretold(last, rival) for rival in rivals)
        if not needless and walk is kept[0]:
            plain = next((one for one in telling if not is_course(one, last)), None)
            together = _fits_beside(plain, tried, split) if plain is not None else []
            needless = any(is_foretold(last, pair) for pair in together)
        others = [one for one in kept if (one.cause, one.form) != (walk.cause, walk.form)]
        kept = others if needless else _for_courses(walk, others, last, channel)
    return kept


def _telling_most(by_merit: Sequence[Candidate], walk: Candidate, channel: str) -> list[Candidate]:
    """The other candidates, those that tell most in a channel first, whatever else is hidden that gains more
    elsewhere."""
    others = [one for one in by_merit if one.form != walk.form and one.merit > PRICE_NATS]
    return sorted(others, key=lambda one: -one.gains.get(channel, 0.0))


def _fits_beside(plain: Candidate, tried: Sequence[Form], split: Split) -> list[Fit]:
    """Quick fits of other causes of the same place beside one that tells a part: a walk takes what two foretell
    together, such as a bias that drifts and an axis that leans. None where no time is left."""
    place = DECLARED[plain.cause].place
    others = [
        one
        for one in tried
        if one.id != plain.cause and one.added is None and DECLARED[one.id].place == place
    ]
    try:
        ground = ground_of(plain.fit, split)
        begun, _ = begun_fits(Whitened(make_data(plain.fit.world, split), plain.fit, ground.slopes), others)
        best = sorted(begun, key=lambda one: -one.promised)[:_BESIDE]

        def fitted(one: Begun) -> Fit | None:
            try:
                return refitted(ground, one)
            except OutOfTime:
                return None

        return [one for one in shared_out(fitted, best, [plain.fit, *best]) if one is not None]
    except OutOfTime:
        return []


def _for_courses(walk: Candidate, others: list[Candidate], last: Fit, channel: str) -> list[Candidate]:
    """A walk and the other candidates, without the courses of its cause that tell less of its channel than it does.
    They are the same mechanism, followed less closely, and what the log score makes of them is the least that it is
    worth: a walk that stands was found to be the whole of what is left there."""
    told = walk.gains.get(channel, 0.0)
    courses = [
        one
        for one in others
        if one.cause == walk.cause and is_course(one, last) and one.gains.get(channel, 0.0) < told
    ]
    best = max(courses, key=lambda one: one.merit, default=walk)
    if best.merit > walk.merit:
        walk = replace(walk, merit=best.merit, nats=best.nats, held_out_gain=best.held_out_gain)
    return sorted([walk, *(one for one in others if one not in courses)], key=lambda one: -one.merit)
