"""Held-out blocks that nobody could have foretold: a blow fell there, or just before, and what it shook died away
before the rest."""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.fit import Data, Fit, Split, make_data
from stillarm.diagnosis.noise import HUBER

_MISFIT = 2.0  # times the channel's variance, outliers bounded
_CLOSE_MISFIT, _CHANCE = 1.2, 4.0  # the same; standard errors of a mean square
_SHOWING = ("acceleration", "deflection", "displacement")


def predictable(split: Split, *fits: Fit, closely: bool = False) -> NDArray[np.bool_]:
    """Which blocks all of the fits could have foretold. (blocks,)

    closely: as nearly as chance allows. A cause that explains a block is close; where it is off with the cause as
    without, what the cause moves a little is multiplied by how far off it is, and tens of nats say nothing of it.
    """
    found = np.ones(len(split.held), bool)
    for one in fits:
        if _struck(one, split):
            found &= ~unpredictable(make_data(one.world, split), one, closely)
    return found


def unpredictable(data: Data, last: Fit, closely: bool = False) -> NDArray[np.bool_]:
    """Which blocks: the state after a blow is fitted to the training part alone, which knows nothing of a mode that
    has faded by then. Such a block's thousands of nats hang on the last digit of the first mode, and say nothing of
    any cause. (blocks,)"""
    split = data.split
    found = np.zeros(len(split.held), bool)
    for block in _struck(last, split):
        found[block] = any(
            _strays(last, name, data.held[name] & (data.blocks[name] == block), closely)
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


def _strays(last: Fit, name: str, here: NDArray[np.bool_], closely: bool) -> bool:
    """Whether a channel's mean square there is more than it may be."""
    u = np.clip(last.residuals[name][here] / last.sigma[name], -HUBER, HUBER)
    if not len(u):
        return False
    most = min(_MISFIT, max(_CLOSE_MISFIT, 1.0 + _CHANCE * (2.0 / len(u)) ** 0.5)) if closely else _MISFIT
    return float(np.mean(u * u)) > most
