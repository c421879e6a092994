"""Which causes and which structure the recording asks for, round by round, until nothing gains more than chance.

The starts of all forms are screened, and the best few fitted. What a form is worth, its merit,
is what it gains in the log score by blocks and frequencies, less 3 nats for each number that it adds; where it gains
less on the blocks that no fit saw, three times that counts. So that docs/diagnosis.md's scale holds here too.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import inf, log

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.driven.fitting.bounds import LEAST_ZETA, MOST_ZETA
from stillarm.diagnosis.driven.fitting.fitting import SEARCH_STEPS, DrivenFit, fit
from stillarm.diagnosis.driven.fitting.freedom import STATED
from stillarm.diagnosis.driven.mechanisms.extents import forms_of_all
from stillarm.diagnosis.driven.mechanisms.mechanisms import STRUCTURE, Form, forms_for
from stillarm.diagnosis.driven.recording.own import recording_of
from stillarm.diagnosis.driven.recording.signals import Driven
from stillarm.diagnosis.driven.search.from_start import fitted_from, moved_along
from stillarm.diagnosis.driven.search.judging import (
    CONVINCES,
    Tried,
    best_merit,
    judged,
    lags_told,
    least_step,
    may_win,
)
from stillarm.diagnosis.driven.search.plays import plays
from stillarm.diagnosis.driven.search.rests import leaves_much
from stillarm.diagnosis.driven.search.screen import Screen
from stillarm.diagnosis.driven.starts.start import linear_start, with_another_mode
from stillarm.diagnosis.driven.starts.stated import Stated

Array = NDArray[np.float64]
Tick = Callable[[float, str], None]

_MOST_FITS, _MOST_STARTS = 10, 2  # of a round; of a form: what a round costs
_TRIED_ANYWAY = 1.0  # share of a form that no small step shows: it is fitted before all others
# of what the best start explains: play that explains less is fitted once nothing else gains
_PLAY_PROMISES = 0.15
_LEAST_SHARE = 1e-4  # of the squared residual, that a start's direction explains
_MOST_ROUNDS = 7  # and so causes and structure, beside the first model
_MOST_MODES = 3  # that a fit adds to the arm, each with four numbers of its own and more
_CAUSE_FIRST, _LINEAR_FIRST = 0.3, 0.7  # of what structure gains
_OF_NO_ARM = 0.1  # of what a mode gains counts, that is none of an arm
_SOME_FORMS = "some forms of causes"
_LINEAR = (
    "channel_delay",
    "sensor_lag",
    "gravity_load",
    "sensor_scale",
    "inertia_change",
)
ANOTHER_MODE = Form(
    STRUCTURE, "a further mode", ("log_w", "zeta", "follows", "carries"), lambda fitted: iter(())
)


@dataclass(frozen=True)
class Round:
    """What was taken, of all that was tried, best first, and the fit before it."""

    before: DrivenFit
    tried: tuple[Tried, ...]

    @property
    def taken(self) -> Tried:
        """The best."""
        return self.tried[0]


@dataclass(frozen=True)
class Searched:
    """start: the linear model; rounds: each with what it took; final: with all of that; last: what was tried in
    vain at the end."""

    start: DrivenFit
    rounds: tuple[Round, ...]
    final: DrivenFit
    last: tuple[Tried, ...]
    left_out: tuple[str, ...]


def search(
    driven: Driven,
    split: Split,
    tick: Tick,
    left_s: Callable[[], float] = lambda: inf,
    stated: Stated | None = None,
    declared: Mapping[str, float] | None = None,
) -> Searched:
    """Search within the time that `left_s` tells. stated, declared: what a model file says of joint and causes."""
    tick(0.05, "a start from the data")
    start = linear_start(driven, split, stated, declared)
    current = start
    rounds: list[Round] = []
    last: tuple[Tried, ...] = ()
    left_out: list[str] = []
    begun = left_s()
    for number in range(_MOST_ROUNDS):
        tick(0.15 + 0.8 * number / _MOST_ROUNDS, "causes")
        spare = left_s() if begun == inf else left_s() - 0.1 * begun
        if spare < 0.0:
            left_out.append("further rounds")
            break
        tried = tried_forms(current, left_s)
        if left_s() < 0.0:  # an answer that says nothing of it would pass for one that has tried them all
            left_out.append(_SOME_FORMS)
        if not tried or tried[0].merit < CONVINCES:
            last = tuple(tried)
            break
        tried = plainer_first(cause_first(tried))
        rounds.append(Round(current, tuple(tried)))
        current = settled(tried[0].fit)
    return Searched(start, tuple(rounds), current, last, tuple(left_out))


def settled(taken: DrivenFit) -> DrivenFit:
    """The fit that was taken, fitted on, as what is left of a cause's own error would pass for another cause; and with
    the input held or linear between samples, as the start's choice was made without the cause."""
    other = {**taken.numbers, "held": 1.0 - taken.numbers.get("held", 0.0)}
    fits = [
        fit(taken.box, one, taken.free, taken.states, steps=SEARCH_STEPS) for one in (taken.numbers, other)
    ]
    return max(taken, *fits, key=lambda one: float(one.likeliest.whole.sum()))


def holds_in(plain: Form, rich: Form) -> bool:
    """Whether a form is another with further numbers: that does as well by itself, and says no more until it wins its
    odds."""
    return set(plain.numbers) < set(rich.numbers)


def _is_limit_of(plain: Form, rich: Form) -> bool:
    """Whether a form is what another one becomes where the joint turns little: of gravity a constant torque is left."""
    return plain.cause == "torque_offset" and rich.cause == "gravity_load"


def plainer_first(tried: list[Tried]) -> list[Tried]:
    """The plainest form of those that the best one holds, where the best does not win its odds against it."""
    plainer = [
        one
        for one in tried
        if (holds_in(one.form, tried[0].form) or _is_limit_of(one.form, tried[0].form))
        and one.merit >= max(CONVINCES, tried[0].merit - CONVINCES)
    ]
    if not plainer:
        return tried
    best = min(plainer, key=lambda one: (one.form.price, -one.merit))
    return [best, *(one for one in tried if one is not best)]


def cause_first(tried: list[Tried]) -> list[Tried]:
    """The best cause before structure that gains no more than some times as much, and what proves needless is taken out
    in the end. A further mode without damping can imitate friction and all else that is not linear, while no friction
    imitates a mode; a cause that is linear itself has a smaller lead, for its fewer numbers, and so has play, as a mode
    and play imitate each other."""
    most = tried[0].merit
    for one in tried:
        if one.form.cause != STRUCTURE and one.merit >= max(CONVINCES, lead_of(one.form) * most):
            return [one, *(other for other in tried if other is not one)]
    return tried


def lead_of(form: Form) -> float:
    """How much a cause must gain, of what structure does, to go first."""
    return _LINEAR_FIRST if form.cause in _LINEAR or form.play else _CAUSE_FIRST


def _at_a_bound(fitted: DrivenFit) -> bool:
    """Whether the last mode has the least or the most damping that a fit may give: an arm has neither."""
    zeta = fitted.numbers[f"zeta_{fitted.box.modes}"]
    return not 2.0 * LEAST_ZETA < zeta < 0.99 * MOST_ZETA


def tried_forms(current: DrivenFit, left_s: Callable[[], float]) -> list[Tried]:
    """Every form beside what there is, best first."""
    screen = Screen(current)
    begins: list[tuple[float, Form, dict[str, float]]] = []
    finished: list[Tried] = []
    forms = (forms_for if not current.box.driven.joins else forms_of_all)(current)
    for form in [one for one in forms if not one.play]:
        for start in form.starts(current):
            share, along = (_TRIED_ANYWAY, 1.0) if form.hidden else screen.share(start)
            here = start if form.hidden else moved_along(current, start, along)
            begins.append((share, form, here))
    promised = max((share for share, form, _ in begins if not form.hidden), default=0.0)
    played = [one for one in forms if one.play]
    for form in played:
        finished += plays(form, current, screen, left_s, _PLAY_PROMISES * promised)
    put_off = not finished
    done: dict[tuple[str, str, bool, int | None], int] = {}
    for share, form, start in sorted(begins, key=lambda one: -one[0]):
        key = (form.cause, form.words, form.hidden, recording_of(form.numbers[0]))
        many = _MOST_STARTS if recording_of(form.numbers[0]) is None else 1
        if (
            left_s() < 0.0
            or done.get(key, 0) >= many
            or sum(done.values()) >= _MOST_FITS
            or share < _LEAST_SHARE
        ):
            continue
        done[key] = done.get(key, 0) + 1
        fitted = fitted_from(form, start, current, least_step(finished, SEARCH_STEPS))
        finished += [judged(form, fitted, current)] if fitted is not None else []
    bends = current.box.modes < _MOST_MODES and current.numbers.get(STATED, 0.0) == 0.0
    if bends and left_s() > 0.0:
        bent = with_another_mode(current, least_step(finished, SEARCH_STEPS))
        if bent is not None:
            many = len(bent.free) - len(current.free)
            mode = judged(replace(ANOTHER_MODE, numbers=ANOTHER_MODE.numbers[:many]), bent, current)
            # noise may ring at any of the recording's frequencies, and the best of them was chosen
            elsewhere = log(max(current.box.driven.samples // 2, 1))
            counts = _OF_NO_ARM if _at_a_bound(bent) else 1.0
            finished.append(replace(mode, merit=counts * (mode.merit - elsewhere)))
    if put_off and best_merit(finished) < CONVINCES and leaves_much(current):  # no later round will fit it
        for form in played:
            finished += plays(form, current, screen, left_s, _LEAST_SHARE)
    return sorted(lags_told(_rivals_to_the_end(finished, current)), key=lambda one: -one.merit)


def _rivals_to_the_end(tried: list[Tried], current: DrivenFit) -> list[Tried]:
    """With those fitted on that were given up near the best, as odds of some nats decide between causes; a further mode
    stands behind a cause by far more."""
    best = best_merit(tried)
    goes_on = [may_win(one, best) and one.form.words != ANOTHER_MODE.words for one in tried]
    return [_fitted_on(one, current) if goes else one for one, goes in zip(tried, goes_on, strict=True)]


def _fitted_on(one: Tried, current: DrivenFit) -> Tried:
    fitted = fit(one.fit.box, one.fit.numbers, one.fit.free, one.fit.states, SEARCH_STEPS)
    return judged(one.form, fitted, current)
