"""Fits begun on what moves, for friction that holds the arm.

Held, the arm stands where its last swing ended, up to F / w^2 to either side. One swing more or fewer puts it on the
other side, so that the likelihood of what stands has an optimum for each number of swings: for an arm that swings
a dozen times, at sizes a twelfth apart, and Gauss-Newton steps end in the nearest. What moves has one broad
optimum; from there the nearest is the right one.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.fit import Colours, Data, Fit, fit, least_level
from stillarm.diagnosis.side_by_side import side_by_side

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_SHOWING = ("displacement", "deflection")
_STILL = 5.0  # times the level of what stands: below it nothing moves
_QUIETEST = 0.05  # of the samples, which are as quiet as the channel gets
_LEAST_AT_REST, _FEWEST_MOVING = 0.05, 100  # of the training samples; of them
_ITERATIONS, _ITERATIONS_BESIDE = 12, 6
_STEP, _MOST_STEPS = 1.25, 8
_BETTER_NATS = 1.0


def begun_on_what_moves(
    data: Data, start: Array, size: str, free: Sequence[str], colour: Colours
) -> Array | None:
    """Where to begin a fit of all that trains: the fit of what moves, with a search along `size` by steps of a quarter.
    None where the arm hardly stands. free: names of the quantities, `size` among them."""
    part = moving_part(data, data.world.space["modes.0.frequency_hz"].start)
    if part is None:
        return None
    best = fit(part, start, free, iterations=_ITERATIONS, colour=colour)
    ways = [_STEP, 1.0 / _STEP]
    for _ in range(_MOST_STEPS):
        tried = side_by_side(partial(_beside, part, best, size, colour), ways)
        better, way = max(zip(tried, ways, strict=True), key=lambda one: one[0].train_log_likelihood)
        if better.train_log_likelihood < best.train_log_likelihood + _BETTER_NATS:
            break
        best, ways = better, [way]  # there is one optimum: the other way is where it came from
    return best.vector


def _beside(part: Data, best: Fit, size: str, colour: Colours, factor: float) -> Fit:
    """The fit from another size: of all else first, since the blows' sizes and the arm's damping have to follow."""
    start = part.world.space.with_values(best.vector, {size: factor * best.value(size)})
    others = [name for name in best.free if name != size]
    there = fit(part, start, others, iterations=_ITERATIONS_BESIDE, colour=colour)
    return fit(part, there.vector, best.free, iterations=_ITERATIONS, colour=colour)


def moving_part(data: Data, hz: float) -> Data | None:
    """The training samples without those of image and deflection at which the arm stands: a period of `hz` about them
    shows no more than noise. None where that is hardly any, or nearly all."""
    train = dict(data.train)
    for name in _SHOWING:
        if name not in train:
            continue
        spread = _spread(data.world.channels[name], max(3, round(1.0 / (hz * data.world.step_s(name)))))
        known = np.isfinite(data.world.channels[name])
        quiet = max(float(np.quantile(spread[known], _QUIETEST)), least_level(data.world, name))
        train[name] = train[name] & (spread > _STILL * quiet)
        if not _FEWEST_MOVING < train[name].sum() < (1.0 - _LEAST_AT_REST) * data.train[name].sum():
            return None
    return replace(data, train=train) if any(name in train for name in _SHOWING) else None


def _spread(values: Array, width: int) -> Array:
    """Standard deviation of the known values among `width` about each. (n,)"""
    known = np.isfinite(values)
    filled = np.where(known, values - np.mean(values[known]), 0.0)

    def sums(of: Array) -> Array:
        return np.asarray(np.convolve(of, np.ones(width), "same"))

    count = np.maximum(sums(known.astype(np.float64)), 1.0)
    mean = sums(filled) / count
    return np.asarray(np.sqrt(np.maximum(sums(filled * filled) / count - mean * mean, 0.0)))
