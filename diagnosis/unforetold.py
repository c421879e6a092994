"""Held-out blocks that nobody could have foretold: a blow fell there, or just before, and what it shook died away
before the rest."""

import numpy as np
from numpy.typing import NDArray

from diagnosis.fit import Data, Fit, Split, make_data
from diagnosis.noise import HUBER

_MISFIT = 2.0  # times the channel's variance, outliers bounded
_SHOWING = ("acceleration", "deflection", "displacement")


def foretold(split: Split, *fits: Fit) -> NDArray[np.bool_]:
    """Which blocks all of the fits could have foretold. (blocks,)"""
    found = np.ones(len(split.held), bool)
    for one in fits:
        if _struck(one, split):
            found &= ~unforetold(make_data(one.world, split), one)
    return found


def unforetold(data: Data, last: Fit) -> NDArray[np.bool_]:
    """Which blocks: the state after a blow is fitted to the training part alone, which knows nothing of a mode that
    has faded by then. Such a block's thousands of nats hang on the last digit of the first mode, and say nothing of
    any cause. (blocks,)"""
    split = data.split
    found = np.zeros(len(split.held), bool)
    for block in _struck(last, split):
        found[block] = any(
            _misfit(last, name, data.held[name] & (data.blocks[name] == block)) > _MISFIT
            for name in _SHOWING
            if name in last.residuals
        )
    return found


def _struck(last: Fit, split: Split) -> list[int]:
    """Held-out blocks with a blow, or that begin within a period of the first mode after one: from less of it the
    training part does not tell how the arm rings on."""
    times = np.array(last.world.impacts, dtype=np.float64) * last.world.measured.cycle_s
    if not len(times):
        return []
    until = times + 1.0 / last.value("modes.0.frequency_hz")
    blocks = np.concatenate((split.blocks_of(times), split.blocks_of(until)))
    return [int(block) for block in np.unique(blocks) if split.held[block]]


def _misfit(last: Fit, name: str, here: NDArray[np.bool_]) -> float:
    u = np.clip(last.residuals[name][here] / last.sigma[name], -HUBER, HUBER)
    return float(np.mean(u * u)) if len(u) else 0.0
