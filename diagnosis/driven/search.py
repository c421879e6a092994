"""Which causes and which structure the recording asks for, round by round, until nothing gains more than chance.

Each form is fitted for a few steps from each of its starts; the best few to the end. What a form is worth, its merit, is
what it gains in the log score by blocks and frequencies, less 3 nats for each number that it adds; where it gains less
on the blocks that no fit saw, three times that counts. So that docs/diagnosis.md's scale holds here too.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.driven.fitting import DrivenFit, fit
from stillarm.diagnosis.driven.mechanisms import STRUCTURE, Form, box_of, forms_for
from stillarm.diagnosis.driven.signals import Driven
from stillarm.diagnosis.driven.start import has_joint, linear_start, with_another_mode

Array = NDArray[np.float64]
Tick = Callable[[float, str], None]

CONVINCES = 12.0  # nats: 20 to 1 against all that is tried
PRICE = 3.0  # nats for each number
_QUICK, _BEST = 4, 4
_MOST_ROUNDS = 7
_MOST_MODES = 3
ANOTHER_MODE = Form(STRUCTURE, "a further mode", ("log_w", "zeta", "follows", "carries"), lambda fitted: iter(()))


@dataclass(frozen=True)
class Tried:
    """A form with its best fit. merit: nats; held: gained on held-out blocks."""

    form: Form
    fit: DrivenFit
    merit: float
    held: float


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


def search(driven: Driven, split: Split, tick: Tick, left_s: Callable[[], float] = lambda: inf) -> Searched:
    """Search within the time that `left_s` tells."""
    tick(0.05, "a start from the data")
    start = linear_start(driven, split)
    current, rounds, last, left_out = start, [], (), []
    begun = left_s()
    for number in range(_MOST_ROUNDS):
        tick(0.15 + 0.8 * number / _MOST_ROUNDS, "causes")
        spare = left_s() if begun == inf else left_s() - 0.1 * begun
        if spare < 0.0:
            left_out.append("further rounds")
            break
        tried = tried_forms(current, left_s)
        if not tried or tried[0].merit < CONVINCES:
            last = tuple(tried)
            break
        rounds.append(Round(current, tuple(tried)))
        current = tried[0].fit
    return Searched(start, tuple(rounds), current, last, tuple(left_out))


def tried_forms(current: DrivenFit, left_s: Callable[[], float]) -> list[Tried]:
    """Every form beside what there is, best first."""
    quick: list[Tried] = []
    for form in forms_for(current):
        if left_s() < 0.0:
            break
        from_here = box_of(form, current)
        free = tuple(dict.fromkeys((*current.free, *(one for one in form.numbers if one != "late"))))
        for start in form.starts(current):
            begun = fit(from_here.box, {**current.numbers, **start}, free, from_here.states, steps=_QUICK)
            quick.append(judged(form, begun, current))
    best_of: dict[tuple[str, str], Tried] = {}
    for one in quick:
        key = (one.form.cause, one.form.words)
        if key not in best_of or one.merit > best_of[key].merit:
            best_of[key] = one
    ranked = sorted(best_of.values(), key=lambda one: -one.merit)
    finished = [
        judged(one.form, fit(one.fit.box, one.fit.numbers, one.fit.free, one.fit.states), current)
        for one in ranked[:_BEST]
        if one.merit > -PRICE * 4.0
    ]
    finished = [max(new, old, key=lambda one: one.merit) for new, old in zip(finished, ranked, strict=False)]
    if current.box.modes < _MOST_MODES and not current.box.play and left_s() > 0.0:
        bent = with_another_mode(current)
        if bent is not None:
            many = len(bent.free) - len(current.free)
            finished.append(judged(replace(ANOTHER_MODE, numbers=ANOTHER_MODE.numbers[:many]), bent, current))
    return sorted([*finished, *ranked[_BEST:]], key=lambda one: -one.merit)


def judged(form: Form, fitted: DrivenFit, before: DrivenFit) -> Tried:
    """A form's merit against the fit before it."""
    gained, held = float((fitted.whole - before.whole).sum()), 0.0
    inside = fitted.box.split.held
    held = float((fitted.held_out - before.held_out)[inside].sum())
    worth = min(gained, 3.0 * held) - PRICE * form.price
    return Tried(form, fitted, worth if np.isfinite(worth) else -inf, held)


__all__ = ["CONVINCES", "Round", "Searched", "Tried", "has_joint", "search"]
