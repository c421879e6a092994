"""What a grey box leaves of a recording, in each output's deviation, and how that changes with numbers and states.

Derivatives are differences: one simulation for each number, and one for each component of the state, of all blocks at
once.
"""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.gauss_newton import Piece
from stillarm.diagnosis.driven.greybox import GreyBox, Run

Array = NDArray[np.float64]

ASTRAY = 1e8
"""Times the deviation: no number any more."""
_DIFFERENCE = 1e-3  # of a number: over much less, the corners of friction make a derivative of their own
_OF_PLAY = 0.05  # of play's own numbers: an impact falls to a simulated step, and moves by whole ones
_MOST_UNEVEN = 0.15  # of the largest share of an output's variation that is left: the least of another


def first_levels(box: GreyBox) -> dict[str, float]:
    """A first deviation of each output, by which they are weighed: a share of its variation."""
    return {one.name: max(0.05 * float(np.nanstd(one.values)), one.step, 1e-12) for one in box.driven.outputs}


def levels_of(box: GreyBox, errors: dict[str, Array], sigma: dict[str, float]) -> dict[str, float]:
    """The outputs' deviations as they are, but none so small against another's that the fit would give that up."""
    train = ~box.split.held[box.block]
    found, share = {}, {}
    for one in box.driven.outputs:
        rms = float(np.sqrt(np.nanmean((errors[one.name][train] * sigma[one.name]) ** 2)))
        usual = float(np.nanstd(one.values))
        found[one.name] = max(rms, 0.29 * one.step, 1e-9 * usual)
        share[one.name] = found[one.name] / usual
    most = max(share.values())
    return {name: level * max(1.0, _MOST_UNEVEN * most / share[name]) for name, level in found.items()}


def cost_of(
    box: GreyBox, numbers: dict[str, float], states: Array, sigma: dict[str, float]
) -> tuple[float, dict[str, Array]]:
    """Half the sum of squares of the blocks that train, and each output's errors, in deviations."""
    with np.errstate(over="ignore", invalid="ignore"):
        run = box.run(numbers, states)
    train = ~box.split.held[box.block]
    total, errors = 0.0, {}
    for one in box.driven.outputs:
        error = (one.values - run.outputs[one.name]) / sigma[one.name]
        known = np.isfinite(one.values)
        error[known & ~(np.abs(error) < ASTRAY)] = ASTRAY
        error[~known] = np.nan
        errors[one.name] = error
        total += 0.5 * float(np.nansum(error[train] ** 2))
    return total, errors


def by_block(box: GreyBox, errors: dict[str, Array]) -> Array:
    """Each block's sum of squares."""
    total = sum(np.nan_to_num(one) ** 2 for one in errors.values())
    return np.asarray(np.bincount(box.block, np.asarray(total), minlength=len(box.starts) - 1), np.float64)


def derivatives(
    box: GreyBox, numbers: dict[str, float], free: tuple[str, ...], states: Array, sigma: dict[str, float],
    errors: dict[str, Array],
) -> list[Piece]:  # fmt: skip
    """Of each block: by the free numbers, by its state, and what is left of it."""
    base = stacked(box, box.run(numbers, states), sigma)
    columns = []
    for name in free:
        step = difference_of(name, numbers[name], box)
        columns.append(_slope(box, {**numbers, name: numbers[name] + step}, states, sigma, base, step))
    scale = np.maximum(np.std(states, axis=0), 1e-3 * np.max(np.abs(states)) + 1e-9)
    turned = []
    for place in range(box.size):
        other = states.copy()
        other[:, place] += _DIFFERENCE * scale[place]
        turned.append(_slope(box, numbers, other, sigma, base, _DIFFERENCE * scale[place]))
    residual = np.concatenate([errors[one.name] for one in box.driven.outputs])
    by_numbers, by_state = np.array(columns).T.reshape(len(residual), -1), np.array(turned).T
    pieces = []
    for s, rows in enumerate(rows_of_blocks(box, residual)):
        j, k, r = by_numbers[rows], by_state[rows], residual[rows]
        pieces.append((np.nan_to_num(j), np.nan_to_num(k), r, not box.split.held[s]))
    return pieces


def _slope(
    box: GreyBox, numbers: dict[str, float], states: Array, sigma: dict[str, float], base: Array, step: float
) -> Array:
    """A derivative by what was moved by `step`; none where the moved simulation runs away, so that no step is taken."""
    with np.errstate(over="ignore", invalid="ignore"):
        change = stacked(box, box.run(numbers, states), sigma) - base
    known = change[~np.isnan(base)]
    sound = bool(np.isfinite(known).all()) and float(np.max(np.abs(known), initial=0.0)) < ASTRAY
    return change / step if sound else np.zeros_like(base)


def rows_of_blocks(box: GreyBox, residual: Array) -> list[NDArray[np.int64]]:
    """Which of the stacked samples each block holds, of those that were measured."""
    where = np.tile(box.block, len(box.driven.outputs))
    known = np.isfinite(residual)
    order = np.flatnonzero(known)[np.argsort(where[known], kind="stable")]
    blocks = len(box.starts) - 1
    ends = np.cumsum(np.bincount(where[order], minlength=blocks))
    return [order[(ends[s - 1] if s else 0) : end] for s, end in enumerate(ends)]


def difference_of(name: str, value: float, box: GreyBox) -> float:
    """By how much a number is moved for its derivative."""
    if name.startswith(("delay", "lag", "onset")):
        return 0.02 * box.driven.step_s
    if name == "bounce":
        return _OF_PLAY
    if name in ("gap", "share"):
        return _OF_PLAY * max(value, 1e-9)
    return _DIFFERENCE * max(abs(value), 1e-3)


def stacked(box: GreyBox, run: Run, sigma: dict[str, float]) -> Array:
    """All outputs one after the other, in deviations."""
    return np.concatenate([run.outputs[one.name] / sigma[one.name] for one in box.driven.outputs])
