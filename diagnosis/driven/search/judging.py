"""What a form is worth against the fit before it: its merit, in nats."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import inf, isfinite, log

import numpy as np

from stillarm.diagnosis.driven.fitting.bounds import LONGEST_SAMPLES, believable
from stillarm.diagnosis.driven.fitting.fitting import DrivenFit
from stillarm.diagnosis.driven.mechanisms.mechanisms import AMPLIFIER_LAG, STRUCTURE, Form

CONVINCES = 12.0  # nats: 20 to 1 against all that is tried
PRICE = 3.0  # nats for each number
BESIDE_SHARE = 0.05  # of the first finding's worth: what is told beside it
HELD_OUT_TIMES = 3.0  # one block of so many is held out (blocks.py)
AT_TOPS = "drive_saturation"
"""The cause that acts at the tops of the motion alone, which may all lie in blocks that train."""
NEAR_NATS, NEAR_SHARE = 3.0, 0.02
"""Within which two causes are a class: nats, and a share of the better one's merit."""
_RIVAL = 2.0  # times the share of a class: what a fit lacks that was given up, and as much again
_LEAST_GAP = 2e-4  # of the angle's deviation: less is a gear without play
DELAY = "a delay of the input"


@dataclass(frozen=True)
class Tried:
    """A form with its best fit. merit: nats; held: gained on held-out blocks."""

    form: Form
    fit: DrivenFit
    merit: float
    held: float


def least_step(tried: Iterable[Tried], steps: int) -> float:
    """Nats of a step that may change what a round says: with less, all the steps of a fit would not gain the share of
    the best form's merit within which two causes are a class."""
    return NEAR_SHARE / steps * best_merit(tried)


def best_merit(tried: Iterable[Tried]) -> float:
    """Of all that was tried, zero where nothing gains."""
    return max((one.merit for one in tried if isfinite(one.merit)), default=0.0)


def may_win(one: Tried, best: float) -> bool:
    """Whether a fit that was given up is so near the best that its last nats count."""
    return one.fit.given_up and one.merit >= (1.0 - _RIVAL * NEAR_SHARE) * best


def gains(form: Form, fitted: DrivenFit, before: DrivenFit) -> tuple[float, float]:
    """Nats that a form gains, on all blocks and on those held out.

    An impact that falls a sample late doubles what is left at high frequencies, whatever it explains at low ones. So a
    model with impacts foretells up to a frequency, beyond which the fit before it does, and pays the logarithm of the
    number of frequencies that this one was chosen from.
    """
    fitted, before = fitted.likeliest, before.likeliest
    whole = (fitted.whole_bands - before.whole_bands).sum(axis=0)
    held = (fitted.held_bands - before.held_bands)[fitted.box.split.held].sum(axis=0)
    if not form.play:
        return float(whole.sum()), float(held.sum())
    reached = np.cumsum(whole)
    last = int(np.argmax(np.where(np.isfinite(reached), reached, -inf)))
    return float(reached[last]) - log(len(whole)), float(held[: last + 1].sum())


def judged(form: Form, fitted: DrivenFit, before: DrivenFit) -> Tried:
    """A form's merit against the fit before it."""
    if "late" in form.numbers and fitted.numbers["delay"] <= LONGEST_SAMPLES * fitted.box.driven.step_s:
        # what the plain model may have, and its fit did not reach
        form = replace(form, cause=STRUCTURE, words=DELAY)
    gained, held = gains(form, fitted, before)
    worth = min(gained, _of_all(form, fitted, gained, held)) - PRICE * form.price
    travel = float(np.std(fitted.run.states[:, 0]))
    if form.play and fitted.numbers["gap"] < _LEAST_GAP * travel:
        worth = -inf
    if not believable(form.numbers, fitted.numbers, fitted.box.driven.step_s):
        worth = -inf
    return Tried(form, fitted, worth if np.isfinite(worth) else -inf, held)


def _of_all(form: Form, fitted: DrivenFit, gained: float, held: float) -> float:
    """What a form gains on all blocks, by what it gains on those held out: three times that, as every third is. A limit
    acts at the tops of the motion alone: it gains by as many of them as were held out; where none was, nothing is said.
    One that acts in no block that trains was not fitted: its value is the one of those tried that suits what was held
    out.
    """
    if form.cause != AT_TOPS:
        return HELD_OUT_TIMES * held
    box = fitted.box
    limit = fitted.numbers.get(form.numbers[0], inf)
    acts = np.abs(box.driven.u) > limit
    share = float(acts[box.split.held[box.block]].sum()) / max(float(acts.sum()), 1.0)
    if share == 1.0:
        return 0.0
    return held / share if share > 0.0 else gained + HELD_OUT_TIMES * min(held, 0.0)


def lags_told(tried: list[Tried]) -> list[Tried]:
    """Every amplifier lags: that the input or a sensor comes late is a cause by odds against that alone. Without, the
    input's delay is structure, and a sensor's says nothing."""
    lag = max((one.merit for one in tried if one.form.words == AMPLIFIER_LAG), default=-inf)
    return [_without_odds(one) if one.merit < lag + CONVINCES else one for one in tried]


def _without_odds(one: Tried) -> Tried:
    if "late" in one.form.numbers:
        return replace(one, form=replace(one.form, cause=STRUCTURE, words=DELAY))
    return replace(one, merit=-inf) if one.form.cause in ("channel_delay", "sensor_lag") else one
