"""When something happened once: located by all data, and refitted where the likelihood has no smooth derivative."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from stillarm.diagnosis.cause import Cause
from stillarm.diagnosis.fit import Fit, Split, fit, make_data

Array = NDArray[np.float64]

ONSETS = 41
# onsets of steps of the frames' dates: one frame shows them, beside a delay that wanders
AT_ONCE = ("timing.step_onset_s", "timing.stale_onset_s")
_ONSET_REACH_S = 0.8
_MOST_TRIALS = 40  # of a quantity that settles: where each gains a little, all the rest has a long way to go


def onset_seen(refitted: Fit, cause: Cause, split: Split) -> tuple[Fit, float]:
    """The likeliest onset, and its standard deviation, s. What happens once may happen where it is held out, and no
    other part tells when: so all data locate it, and what the held-out part is worth is the logarithm of its mean
    likelihood over all onsets, each by what the training part has for it."""
    name = onset_of(cause)
    if name is None:
        return refitted, 0.0
    now = refitted.value(name)
    received = refitted.world.in_order_s
    if name.startswith("timing.") and len(received) > 2:
        tried = refitted.world.just_before(np.abs(received - now) < _ONSET_REACH_S)
    else:
        tried = now + np.linspace(-_ONSET_REACH_S, _ONSET_REACH_S, ONSETS)
    if len(tried) < 3:
        return refitted, 0.0
    train, held = _by_onset(refitted, name, tried, split)
    best = int(np.argmax(train + held.sum(axis=1)))
    vector = refitted.world.space.with_values(refitted.vector, {name: tried[best]})
    moved = fit(make_data(refitted.world, split), vector, refitted.free, iterations=3, colour=refitted.colour)
    train, held = _by_onset(moved, name, tried, split)
    odds = _odds(train)
    averaged = logsumexp(np.log(np.maximum(odds, 1e-300))[:, None] + held, axis=0)
    located = _odds(train + held.sum(axis=1))
    spread = float(np.sqrt(located @ (tried - located @ tried) ** 2)) + 0.25 * float(
        np.median(np.diff(tried))
    )
    return replace(moved, held_out_score=averaged), spread


def _odds(nats: Array) -> Array:
    odds = np.exp(nats - nats.max())
    known: Array = odds / odds.sum()
    return known


def _by_onset(one: Fit, name: str, tried: Array, split: Split) -> tuple[Array, Array]:
    """Log-likelihood of the training part, and of each held-out block, for each onset."""
    data = make_data(one.world, split)
    train, held = np.empty(len(tried)), np.empty((len(tried), len(split.held)))
    for k, onset in enumerate(tried):
        vector = one.world.space.with_values(one.vector, {name: onset})
        there = fit(data, vector, (), iterations=0, colour=one.colour)
        train[k], held[k] = there.train_log_likelihood, there.held_out_score
    return train, held


def onset_of(cause: Cause) -> str | None:
    """The quantity that is an instant at which something happens once."""
    return next((name for name in cause.settle if "onset" in name), None)


def settled(refitted: Fit, cause: Cause, split: Split) -> Fit:
    """To the end: a search along quantities without a smooth derivative, the step halved, then all fitted anew."""
    best = refitted
    data = make_data(best.world, split)
    own = cause.free(best.world)
    for name, first in cause.settle.items():
        onset = "onset" in name
        # a change of the arm's motion turns the phase of all that follows
        along = refitted.free if name == "arm.onset_s" else own
        step = first * (1.0 if onset else max(abs(best.value(name)), 1e-3) * 10.0)
        least = 4.0 * best.world.measured.cycle_s if onset else 0.02 * step
        trials = 0
        while step > least and trials < _MOST_TRIALS:
            moved = False
            for sign in (1.0, -1.0):
                trials += 1
                start = best.world.space.with_values(best.vector, {name: best.value(name) + sign * step})
                trial = fit(data, start, [n for n in along if n != name], iterations=1, colour=best.colour)
                if trial.train_log_likelihood > best.train_log_likelihood + 0.02:
                    best, moved = trial, True
                    break
            if not moved:
                step *= 0.4
    return fit(data, best.vector, refitted.free, iterations=8, colour=best.colour)
