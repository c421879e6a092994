"""What a form takes away of what the fit without it leaves: in which channel, and how much."""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit
from stillarm.diagnosis.driven.mechanisms.mechanisms import Form
from stillarm.diagnosis.driven.search.judging import AT_TOPS

Array = NDArray[np.float64]


def mended_most(before: DrivenFit, after: DrivenFit) -> tuple[str, float, float]:
    """The channel that is mended most: its name, how much is taken away over what is left, and the relative reduction
    of the held-out error."""
    best = ("", 0.0, 0.0)
    for one in before.box.driven.outputs:
        old, new = before.rms(one.name, True), after.rms(one.name, True)
        share = float(np.sqrt(max(old**2 - new**2, 0.0))) / max(new, 1e-300)
        if share > best[1]:
            best = (one.name, share, 1.0 - new / old)
    return best


def share_mended(form: Form, before: DrivenFit, after: DrivenFit) -> float:
    """How much of a channel's residual a form takes away, on what was held out. A limit acts at the tops of the motion
    alone, which may all lie in blocks that train: of it, what it takes away of the block where that is most."""
    share = mended_most(before, after)[1]
    if form.cause != AT_TOPS:
        return share
    for one in before.box.driven.outputs:
        left = max(after.rms(one.name, True), 1e-300)
        squares = [_by_block(each, one.name) for each in (before, after)]
        share = max(share, float(np.sqrt(max(np.max(squares[0] - squares[1]), 0.0))) / left)
    return share


def _by_block(fitted: DrivenFit, name: str) -> Array:
    """Each block's mean square of an output's residual; zero where it was not measured."""
    known, box = np.isfinite(fitted.residuals[name]), fitted.box
    count = np.bincount(box.block, known, minlength=len(fitted.states))
    squares = np.bincount(box.block, np.nan_to_num(fitted.residuals[name]) ** 2, minlength=len(fitted.states))
    return np.asarray(squares / np.maximum(count, 1.0))


__all__ = ["mended_most", "share_mended"]
