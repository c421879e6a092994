"""What a grey box leaves of a recording, in each output's deviation, and how that changes with numbers and states.

Derivatives are differences: one simulation for each number, and one for each component of the state, of all blocks at
once. Where no law acts, one free run of each component tells all blocks'. Errors are stacked (stack.py), zero where
nothing was measured.
"""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.fitting.gauss_newton import Piece
from stillarm.diagnosis.driven.fitting.showing import free_runs, shown
from stillarm.diagnosis.driven.greybox.greybox import GreyBox

Array = NDArray[np.float64]

ASTRAY = 1e8
"""Times the deviation: no number any more."""
_DIFFERENCE = 1e-3  # of a number: over much less, the corners of friction make a derivative of their own
_OF_PLAY = 0.05  # of play's own numbers: an impact falls to a simulated step, and moves by whole ones
_MOST_UNEVEN = 0.15  # of the largest share of an output's variation that is left: the least of another


def first_levels(box: GreyBox) -> dict[str, float]:
    """A first deviation of each output, by which they are weighed: a share of its variation."""
    return {
        one.name: max(0.05 * usual, one.step, 1e-12)
        for one, usual in zip(box.driven.outputs, box.stack.usual, strict=True)
    }


def levels_of(box: GreyBox, errors: Array, sigma: dict[str, float]) -> dict[str, float]:
    """The outputs' deviations as they are, but none so small against another's that the fit would give that up."""
    train = ~box.split.held
    squares, counts = (one[train].sum(axis=0) for one in (box.stack.squares(errors), box.stack.counts))
    found, share = {}, {}
    for one, usual, square, count in zip(box.driven.outputs, box.stack.usual, squares, counts, strict=True):
        rms = float(np.sqrt(square / count)) * sigma[one.name]
        found[one.name] = max(rms, 0.29 * one.step, 1e-9 * usual)
        share[one.name] = found[one.name] / usual
    most = max(share.values())
    return {name: level * max(1.0, _MOST_UNEVEN * most / share[name]) for name, level in found.items()}


def cost_of(
    box: GreyBox, numbers: dict[str, float], states: Array, sigma: dict[str, float]
) -> tuple[float, Array]:
    """Half the sum of squares of the blocks that train, and the errors, in deviations."""
    with np.errstate(over="ignore", invalid="ignore"):
        told = shown(box, numbers, states, sigma)
        errors = box.stack.measured * box.stack.deviations(sigma) - told
    if not is_sound(errors):
        errors[~(np.abs(errors) < ASTRAY)] = ASTRAY
    if box.stack.known is not None:
        errors[~box.stack.known] = 0.0
    return _cost(box, errors), errors


def _cost(box: GreyBox, errors: Array) -> float:
    return 0.5 * float(box.stack.squares(errors)[~box.split.held].sum())


def is_sound(values: Array) -> bool:
    """Whether no number of a simulation is astray."""
    return bool(np.max(values, initial=0.0) < ASTRAY and np.min(values, initial=0.0) > -ASTRAY)


def by_block(box: GreyBox, errors: Array) -> Array:
    """Each block's sum of squares."""
    return np.asarray(box.stack.squares(errors).sum(axis=1))


def rescaled(
    box: GreyBox, errors: Array, before: dict[str, float], after: dict[str, float]
) -> tuple[float, Array]:
    """Cost and errors in other deviations, of the same simulation."""
    errors = np.clip(errors * (box.stack.deviations(after) / box.stack.deviations(before)), -ASTRAY, ASTRAY)
    return _cost(box, errors), errors


def derivatives(
    box: GreyBox, numbers: dict[str, float], free: tuple[str, ...], states: Array, sigma: dict[str, float],
    errors: Array,
) -> list[Piece]:  # fmt: skip
    """Of each block: by the free numbers, by its state, and what is left of it."""
    slopes = np.empty((len(free) + box.size, len(errors)))
    with np.errstate(over="ignore", invalid="ignore"):
        # not by the errors: what does not show is to differ by nothing
        base = shown(box, numbers, states, sigma)
        for row, name in enumerate(free):
            offset = _offset_of(name, box)
            if offset is not None:
                slopes[row] = box.stack.deviations(sigma) * (box.stack.output == offset)
                continue
            step = difference_of(name, numbers[name], box)
            moved = shown(box, {**numbers, name: numbers[name] + step}, states, sigma)
            _slope(moved, base, step, slopes[row])
        _by_states(box, numbers, states, sigma, base, slopes[len(free) :])
    if box.stack.known is not None:
        slopes *= box.stack.known
    return [
        Piece(slopes[: len(free), a:b].T, slopes[len(free) :, a:b].T, errors[a:b], not held)
        for (a, b), held in zip(box.stack.bounds, box.split.held, strict=True)
    ]


def _offset_of(name: str, box: GreyBox) -> int | None:
    """Of which sensor a number is the offset, which no simulation has to tell. None of any other number, and of an
    accelerometer's, which is in what its filter begins with."""
    for place, one in enumerate(box.driven.outputs):
        if name == f"offset {one.name}" and one.kind != "acceleration" and not box.driven.joins:
            return place
    return None


def _by_states(
    box: GreyBox,
    numbers: dict[str, float],
    states: Array,
    sigma: dict[str, float],
    base: Array,
    slopes: Array,
) -> None:
    """Fill in the derivatives by each component of the blocks' states."""
    told = free_runs(box, numbers, sigma)
    if told is not None:  # (size, outputs, samples of the longest block)
        for (begins, ends), length in zip(box.stack.bounds, np.diff(box.starts), strict=True):
            slopes[:, begins:ends] = told[:, :, :length].reshape(box.size, -1)
        return
    scale = np.maximum(np.std(states, axis=0), 1e-3 * np.max(np.abs(states)) + 1e-9)
    for place in range(box.size):
        other, step = states.copy(), _DIFFERENCE * scale[place]
        other[:, place] += step
        _slope(shown(box, numbers, other, sigma), base, step, slopes[place])


def _slope(moved: Array, base: Array, step: float, slope: Array) -> None:
    """A derivative by what was moved by `step`; none where a simulation runs away, so that no step is taken."""
    np.subtract(moved, base, out=slope)
    if is_sound(slope):
        slope /= step
    else:
        slope[:] = 0.0


def difference_of(name: str, value: float, box: GreyBox) -> float:
    """By how much a number is moved for its derivative."""
    if name.startswith(("delay", "lag", "onset")):
        return 0.02 * box.driven.step_s
    if name == "bounce":
        return _OF_PLAY
    if name in ("gap", "share"):
        return _OF_PLAY * max(value, 1e-9)
    return _DIFFERENCE * max(abs(value), 1e-3)
