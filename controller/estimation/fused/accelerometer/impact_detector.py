"""An impact at the tip, found from the accelerometer before the image can show it.

Implements Eq. 17 of docs/fused.md.

Generalised likelihood ratio (Willsky and Jones, IEEE Trans. Autom. Control 21, 1976): an impact jumps the modal rates,
so the blocks' residuals after an onset follow sum_i D_i k_i sin(w_i (t - onset)), k_i = (w_i / w_1)^2. For each onset
at the start of one of the last blocks: D by least squares, and its significance.
"""

from typing import NamedTuple

import numpy as np

from stillarm.controller.estimation.fused.accelerometer.blocks import Block
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions
from stillarm.controller.estimation.fused.small_arrays import summed


class Impact(NamedTuple):
    """An impact at the start of the block `blocks_ago` blocks back (1: the newest), and each mode's rms deflection, m.

    excess: its significance, standard deviations squared, as a multiple of what is asked for.
    """

    blocks_ago: int
    sizes_m: tuple[float, ...]
    excess: float


class ImpactReport(NamedTuple):
    """The accelerometer's evidence of an impact at the time of an image.

    suspicion: of one, standard deviations squared; sees: whether it could see one; in_use: whether its samples count.
    """

    suspicion: float
    sees: bool
    in_use: bool


class ImpactDetector:
    """Watches the residuals of the accelerometer's blocks."""

    def __init__(self, w: list[float], block_s: float, assumed: Assumptions = ASSUMPTIONS) -> None:
        """w: angular frequency of each mode, rad/s."""
        self._assumed = assumed.impact_detector
        ages = np.arange(self._assumed.blocks)
        after = (ages[None, :] - ages[:, None] + 0.5) * block_s  # row: onset at the start of that block
        shape = np.stack(
            [np.where(after > 0.0, (one / w[0]) ** 2 * np.sin(one * after), 0.0) for one in w], axis=1
        )
        self._shape = shape  # (onsets, modes, blocks)
        self._products = shape[:, :, None] * shape[:, None]  # (onsets, modes, modes, blocks)
        self._prior = np.diag([(one / w[0]) ** 4 for one in w])  # modes are struck alike in acceleration
        self._significant = self._assumed.significant + self._assumed.more_per_mode * (len(w) - 1)
        self.suspicion = 0.0
        self.forget()

    def forget(self) -> None:
        """Watch only what comes from now on."""
        self._residuals = [0.0] * self._assumed.blocks
        self._weights = [0.0] * self._assumed.blocks
        self.suspicion = 0.0

    def see(self, block: Block, residual_m: float, variance: float, usual_m: float) -> Impact | None:
        """Process a block's residual with its variance, m^2; returns an impact when there is one.

        usual_m: deflection that an impact may well cause in the first mode.

        suspicion is then the largest significance, standard deviations squared.
        """
        del self._residuals[0], self._weights[0]
        weight = 1.0 / variance if block.count else 0.0
        self._residuals.append(residual_m * weight)
        self._weights.append(weight)
        power = self._products @ np.array(self._weights)
        power += self._prior / max(usual_m, 1e-9) ** 2
        match = self._shape @ np.array(self._residuals)
        if len(self._prior) == 1:
            covariance = 1.0 / power
            sizes = match * covariance[:, 0]
        else:
            covariance = np.linalg.inv(power)
            sizes = (covariance @ match[:, :, None])[:, :, 0]
        evidence = summed(match * sizes, 1)
        best = int(evidence.argmax())
        self.suspicion = float(evidence[best])
        if self.suspicion < self._significant:
            return None
        odds = np.exp(0.5 * (evidence - self.suspicion))  # the onset is uncertain, and with it the size
        power = sizes**2 + np.diagonal(covariance, axis1=1, axis2=2)
        sizes_m = np.sqrt(odds @ power / odds.sum())
        return Impact(
            self._assumed.blocks - best, tuple(sizes_m.tolist()), self.suspicion / self._significant
        )
