"""Where a search is to begin again: from a likelier baseline that a round came upon, beside impacts that a finding
bears out, or with a formula in the place of a course that had been found before it."""

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.events.impacts import with_further_impacts
from stillarm.diagnosis.fitting.evidence import PRICE_NATS, score
from stillarm.diagnosis.fitting.fit import CHANGED_NATS, fit
from stillarm.diagnosis.fitting.fitted import Fit, carried_over, make_data
from stillarm.diagnosis.fitting.rest import anything_but_spikes_matters, explainable
from stillarm.diagnosis.forms.catalogue import forms
from stillarm.diagnosis.physics.computing import OutOfTime
from stillarm.diagnosis.search.begun import ground_of
from stillarm.diagnosis.search.candidates import Candidate, Found, Hint, Stage
from stillarm.diagnosis.search.carried import hinted

_LED_OUT = 3  # forms, from whose fits the baseline's is begun again
_TOLD = 0.5  # of what is explainable beside a finding is left at most, where impacts tell most of it


def to_begin_again(found: Found, split: Split) -> Found | None:
    """Where the search is to begin again, with its last round as a hint: beside impacts that show beside the first
    finding alone, or where the last finding explains by itself what the first, a course, took. None where nowhere."""
    baseline, last = found.baseline, found.findings[-1]
    struck = sum(one.law is None for one in found.findings) == 1
    if not struck and not _explains_it_alone(last, found, split):
        return None
    better = _struck_beside(found, split) if struck else baseline
    if better is None:
        return None
    return Found(baseline, baseline, likelier=better, hint=Hint(baseline, found.stages[-1], struck))


def _explains_it_alone(one: Candidate, found: Found, split: Split) -> bool:
    """Whether a formula that was found beside a course over time explains more by itself than that course did: a course
    follows anything, and the formula may not be found before some of it is out of the way."""
    first, tried = found.findings[0], found.hint is not None and found.hint.taken.cause == one.cause
    courses = any(each.over_time for each in first.fit.world.added)
    if tried or not courses or first.law is not None or one.law is not None or one is first:
        return False
    try:
        alone = hinted(ground_of(found.baseline, split), one, forms(found.baseline.world))
    except OutOfTime:
        return False
    return alone is not None and alone.merit > first.merit


def _struck_beside(found: Found, split: Split) -> Fit | None:
    """The baseline with the impacts that show beside the first finding, where they tell most of what that leaves: a
    model that lacks the finding hides some, and has others made up. None where they do not, or there is no time
    left."""
    last, baseline = found.final, found.baseline
    if (
        last is baseline
        or any(one.over_time for one in last.world.added)
        or not anything_but_spikes_matters(last, split)
    ):
        return None
    try:
        struck = with_further_impacts(last, split)
        impacts = struck.world.impacts
        if impacts == last.world.impacts:
            return None
        left, before = (sum(explainable(one, split).values()) for one in (struck, last))
        price = PRICE_NATS * max(len(struck.free) - len(last.free), 0)
        gained = float(score(struck, split).gain(score(last, split)).sum()) - price
        if left > _TOLD * before or gained < CHANGED_NATS:
            return None
        world = baseline.world.changed(impacts=impacts, borne_out=frozenset(impacts))
        start, names = carried_over(baseline, world), world.baseline_names()
        return fit(make_data(world, split), start, names, colour=baseline.colour)
    except OutOfTime:
        return None


def likelier_baseline(stage: Stage, baseline: Fit, split: Split) -> Fit | None:
    """The baseline fitted again from where the best forms ended, with what they add at nothing, where it is plainly
    the likelier. The baseline had come to rest far from its best then, with a mode that was fitted away, say, and
    whatever was freed beside it led out of there: the gain is no cause's. None where it was at its best, or there is no
    time left."""
    try:
        return _led_out_of(stage, baseline, split)
    except OutOfTime:
        return None


def _led_out_of(stage: Stage, baseline: Fit, split: Split) -> Fit | None:
    space, data = baseline.world.space, make_data(baseline.world, split)
    best = baseline
    for one in [each for each in stage.candidates if each.law is None][:_LED_OUT]:
        own = [name for name in one.fit.free if name not in baseline.free and name in space.place]
        start = carried_over(one.fit, baseline.world)
        start = space.with_values(start, {name: space[name].start for name in own})
        begun = fit(data, start, baseline.free, iterations=1)
        best = max(best, begun, key=lambda each: each.train_log_likelihood)
    if best.train_log_likelihood < baseline.train_log_likelihood + CHANGED_NATS:
        return None
    plain = fit(data, best.vector, baseline.free)
    gained = float(score(plain, split).gain(score(baseline, split)).sum())
    return plain if gained > CHANGED_NATS else None
