"""The blocks' initial states for numbers that stay: each block goes its own way, and keeps what makes it better.

A joint that rubs sticks or slips by how fast it begins. Where a block sticks from its beginning on, no derivative shows
that another velocity would do better; there its state begins anew from what the sensors tell.
"""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.fitting.derivatives import by_block, cost_of, derivatives
from stillarm.diagnosis.driven.fitting.gauss_newton import state_steps
from stillarm.diagnosis.driven.greybox.greybox import GreyBox

Array = NDArray[np.float64]
Numbers = dict[str, float]

_PARTS = (1.0, 0.3, 0.1)  # of a block's own step: across a corner of friction a whole one leads astray
_ROUNDING = 1e-6  # of a block's sum of squares
_LEAST_GAIN = 1e-7  # of it: of 1e5 samples a hundredth of a nat


def begun_states(box: GreyBox, numbers: Numbers, states: Array | None, sigma: dict[str, float]) -> Array:
    """Each block's state as given, or as the sensors tell, whichever does better. What is given may lack the last
    components, which are then as told."""
    told = box.first_states(numbers)
    if states is None:
        return told
    given, kept = told.copy(), min(states.shape[1], box.size)
    given[:, :kept] = states[:, :kept]
    by_told, by_given = (by_block(box, cost_of(box, numbers, one, sigma)[1]) for one in (told, given))
    return np.where((by_told < by_given)[:, None], told, given)


def settled_states(
    box: GreyBox, numbers: Numbers, states: Array, sigma: dict[str, float], turns: int = 2
) -> Array:
    """The blocks' states after some steps; each block keeps the part of a step that makes it better, or stays."""
    _, errors = cost_of(box, numbers, states, sigma)
    squares = by_block(box, errors)
    for _ in range(turns):
        pieces = derivatives(box, numbers, (), states, sigma, errors)
        gains = np.array([one.most_gain for one in pieces]) > _LEAST_GAIN * squares
        if not gains.any():
            break
        step = np.where(gains[:, None], state_steps(pieces, np.zeros(0)), 0.0)
        before = squares
        for part in _PARTS:
            trial = states + part * step
            tried = by_block(box, cost_of(box, numbers, trial, sigma)[1])
            better, worse = tried < squares, tried > (1.0 + _ROUNDING) * squares
            states, squares = np.where(better[:, None], trial, states), np.where(better, tried, squares)
            step = np.where(worse[:, None], step, 0.0)
            if not worse.any():
                break
        if not (squares < before).any():
            break
        _, errors = cost_of(box, numbers, states, sigma)
    return states


__all__ = ["begun_states", "settled_states"]
