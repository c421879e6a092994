"""From when on a form acts: where its fit begins, and the search along its onset."""

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.fitting.fit import SETTLED_NATS, fit
from stillarm.diagnosis.fitting.fitted import Data, Fit, carried_over, make_data
from stillarm.diagnosis.fitting.gains import gain_of, settled_nats
from stillarm.diagnosis.forms.cause import Form
from stillarm.diagnosis.search.begun import Begun, Ground, Pair
from stillarm.diagnosis.search.screen import Scored
from stillarm.diagnosis.search.whitened import Whitened

Array = NDArray[np.float64]

_QUICK = 4  # steps of a fit
_ONSETS, _ONSETS_SPAN = 6, (0.1, 0.85)  # tried over the recording; of its length, the first and the last
# of them, the best by a score test: it takes what changes for linear, and ranks them roughly
_ONSETS_FITTED = 3
# times the size that a score test tells, of what sets in; then times the best of these, and of those
_SIZES, _NEARER = (0.4, 1.0, 2.0, 4.0, 8.0), ((0.7, 0.85, 1.0, 1.2, 1.45), (0.93, 1.0, 1.08))
_ONSET_STEP = 0.07  # of the recording, the first of a search: across a rest, in which any onset is as good
_ONSET_COARSE_S, _ONSET_LEAST_S = 0.02, 0.001  # to which an onset is sought: of all forms; of those that lead
_TIMES_THE_WHOLE = (1.0, 3.0)  # what acts in a part of the recording is larger than what fits the whole of it
_SIZE_FOLLOWS = 3  # steps of a fit, in which the size follows an onset that is off by up to a swing


def sized(white: Whitened, one: Scored, form: Form) -> Array:
    """Where the fit of a form from an onset begins, with the size and the onset that foretell most: what sets in may be
    so large that the answer is in no proportion to it."""
    world, begins = one.world, form.begins
    assert begins is not None and one.begins_s is not None
    start = world.space.with_values(one.start, {begins: one.begins_s})
    still = carried_over(white.last, world)
    base = world.predict(still)
    places = [world.space.place[name] for column in one.trial.columns for name in column]
    onset_at = world.space.place[begins]

    def of_size(times: float) -> Array:
        vector = start.copy()
        vector[places] = still[places] + times * (start[places] - still[places])
        return world.space.clipped(vector)

    def best(tried: list[Array]) -> Array:
        return max(tried, key=lambda vector: white.foretold(world, base, vector))

    for factors in (_SIZES, *_NEARER):  # the size that suits an onset, the onset that suits this, ever nearer
        start = best([of_size(times) for times in factors])
        later = [start.copy() for _ in white.sets_in_s]
        for vector, onset_s in zip(later, white.sets_in_s, strict=True):
            vector[onset_at] = onset_s
        start = best([start, *later])
    return start


def with_onset(ground: Ground, white: Whitened, pair: Pair) -> tuple[Begun, Fit | None]:
    """The form fitted with the instant from which it acts: over a grid and along it by halving steps, by a score test.
    None where no onset of the grid gains more than the same form throughout, or than nothing: the true one is at most a
    twelfth of the recording off the nearest of the grid, and what acts from it on is then mended nearly everywhere."""
    one, whole = pair
    last, world, begins = ground.last, one.world, one.form.begins
    assert begins is not None
    still = carried_over(last, world)
    base, duration = world.predict(still), world.measured.duration_s
    sizes = {name: whole.value(name) for name in one.form.cause.free(world)}

    def foretold(times: float, onset_s: float) -> float:
        values = {name: times * size for name, size in sizes.items()} | {begins: onset_s}
        return white.foretold(world, base, world.space.with_values(still, values))

    grid = [
        (foretold(times, onset_s), times, onset_s)
        for onset_s in (*(np.linspace(*_ONSETS_SPAN, _ONSETS) * duration).tolist(), *white.sets_in_s)
        for times in _TIMES_THE_WHOLE
    ]
    apart_s = (_ONSETS_SPAN[1] - _ONSETS_SPAN[0]) * duration / (_ONSETS - 1)
    data, found = make_data(world, ground.split), []
    for _, times, near_s in sorted(grid, reverse=True)[:_ONSETS_FITTED]:
        onset_s = _sought(partial(foretold, times), near_s, 0.5 * apart_s)
        values = {name: times * size for name, size in sizes.items()} | {begins: onset_s}
        start = world.space.with_values(whole.vector, values)
        found.append(fit(data, start, whole.free, iterations=_QUICK, colour=last.colour, known=ground.slopes))
    best = max(found, key=lambda fitted: gain_of(fitted, last))
    return one, best if gain_of(best, last) >= max(gain_of(whole, last), 0.0) else None


def _sought(nats_at: Callable[[float], float], at_s: float, step_s: float) -> float:
    """Where an onset gains most, by halving steps."""
    nats = nats_at(at_s)
    while step_s > _ONSET_COARSE_S:
        better, there_s = max((nats_at(at_s + way * step_s), at_s + way * step_s) for way in (1, -1))
        if better > nats + SETTLED_NATS:
            nats, at_s = better, there_s
        else:
            step_s *= 0.5
    return at_s


def with_onset_settled(ground: Ground, begins: str, fitted: Fit, data: Data) -> Fit:
    """A fit with its onset at its best: the size follows until it is near, then all else as it is. begins: its
    quantity."""
    swing_s = 1.0 / fitted.value("modes.0.frequency_hz")
    first_s = max(swing_s, _ONSET_STEP * fitted.world.measured.duration_s)
    for steps, iterations in (
        ((first_s, _ONSET_COARSE_S), _SIZE_FOLLOWS),
        ((_ONSET_COARSE_S, _ONSET_LEAST_S), 1),
    ):
        fitted = _onset_sought(ground, begins, fitted, data, steps, iterations)
    return fitted


def _onset_sought(
    ground: Ground, begins: str, best: Fit, data: Data, steps: tuple[float, float], iterations: int
) -> Fit:
    """A fit's onset moved to where it gains most, by halving steps. begins: its quantity; steps: first and least, s;
    iterations: of the fit of all else at each onset."""
    step, least = steps
    space, last = best.world.space, ground.last
    while step > least:
        starts = [
            space.with_values(best.vector, {begins: best.value(begins) + way * step}) for way in (1, -1)
        ]
        tried = [
            fit(data, start, best.free, iterations=iterations, colour=last.colour, known=ground.slopes)
            for start in starts
        ]
        better = max(tried, key=lambda one: gain_of(one, last))
        if gain_of(better, last) > gain_of(best, last) + settled_nats(best, last):
            best = better
        else:
            step *= 0.5
    return best
