"""A blow at the tip, found from the accelerometer before the image can show it.

Generalised likelihood ratio (Willsky and Jones, IEEE Trans. Autom. Control 21, 1976): a blow jumps the modal rate, so
the blocks' residuals after an onset follow D sin(w (t - onset)). For each onset among the last blocks, D and its
significance by least squares.
"""

from typing import NamedTuple

import numpy as np

from controller.fused.blocks import Block

_BLOCKS = 12
_SIGNIFICANT = (
    21.0  # (4.6 standard deviations)^2: by chance once in some ten minutes at a hundred blocks a second
)


class Blow(NamedTuple):
    """A blow that began `blocks_ago` blocks before the newest one's end, of deflection size_m."""

    blocks_ago: int
    size_m: float


class BlowDetector:
    """Watches the residuals of the accelerometer's blocks."""

    def __init__(self, w: float, block_s: float) -> None:
        """w: angular frequency of the first mode, rad/s."""
        ages = np.arange(_BLOCKS)
        after = (ages[None, :] - ages[:, None] + 0.5) * block_s  # row: onset at the start of that block
        self._shape = np.where(after > 0.0, np.sin(w * after), 0.0)
        self._squared = self._shape**2
        self._residuals = [0.0] * _BLOCKS
        self._weights = [0.0] * _BLOCKS

    def forget(self) -> None:
        """Watch only what comes from now on."""
        self._residuals = [0.0] * _BLOCKS
        self._weights = [0.0] * _BLOCKS

    def see(self, block: Block, residual_m: float, variance: float) -> Blow | None:
        """Take in a block's residual with its variance, m^2; returns a blow when there is one."""
        del self._residuals[0], self._weights[0]
        weight = 1.0 / variance if block.count else 0.0
        self._residuals.append(residual_m * weight)
        self._weights.append(weight)
        power = self._squared @ np.array(self._weights) + 1e-300
        match = self._shape @ np.array(self._residuals)
        evidence = match * match / power
        best = int(np.argmax(evidence))
        if evidence[best] < _SIGNIFICANT:
            return None
        return Blow(_BLOCKS - best, float(match[best] / power[best]))

    @property
    def suspicion(self) -> float:
        """The largest significance of a blow within the last blocks, standard deviations squared."""
        power = self._squared @ np.array(self._weights) + 1e-300
        return float(((self._shape @ np.array(self._residuals)) ** 2 / power).max())
