"""Held-out blocks that nobody could have foretold: an impact fell there, or just before, and what it shook died away
before the rest."""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.fit import Data, Fit, Split
from stillarm.diagnosis.noise import HUBER

_MISFIT = 2.0  # times the channel's variance, outliers bounded
_SHOWING = ("acceleration", "deflection", "displacement")


def unpredictable(data: Data, last: Fit) -> NDArray[np.bool_]:
    """Which blocks: the state after an impact is fitted to the training part alone, which knows nothing of a mode that
    has faded by then. Such a block's thousands of nats hang on the last digit of the first mode, and say nothing of
    any cause. (blocks,)"""
    split = data.split
    found = np.zeros(len(split.held), bool)
    for block in _struck(last, split):
        found[block] = any(
            _strays(last, name, data.held[name] & (data.blocks[name] == block))
            for name in _SHOWING
            if name in last.residuals
        )
    return found


def _struck(last: Fit, split: Split) -> list[int]:
    """Held-out blocks with an impact, or that begin within a period of the first mode after one: from less of it the
    training part does not tell how the arm rings on."""
    times = np.array(last.world.impacts, dtype=np.float64) * last.world.measured.cycle_s
    if not len(times):
        return []
    until = times + 1.0 / last.value("modes.0.frequency_hz")
    blocks = np.concatenate((split.blocks_of(times), split.blocks_of(until)))
    return [int(block) for block in np.unique(blocks) if split.held[block]]


def _strays(last: Fit, name: str, here: NDArray[np.bool_]) -> bool:
    """Whether a channel's mean square there is more than it may be."""
    u = np.clip(last.residuals[name][here] / last.sigma[name], -HUBER, HUBER)
    return bool(len(u)) and float(np.mean(u * u)) > _MISFIT
