"""The delay of an image as it is told, and how late images come in the mean."""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.controller.estimation.fused.fusion.state import FusionState

Array = NDArray[np.float64]

_SAMPLED_CYCLES = (
    0.4  # standard deviation: a sensor that runs by itself was sampled some time within the last cycle
)


class ImageDelay:
    """mean_s, variance: of capture delays that were known to a part of a frame, s and s^2."""

    def __init__(self, state: FusionState, cycle_s: float) -> None:
        """As the model has it."""
        self._state = state
        self._sampled_variance = (_SAMPLED_CYCLES * cycle_s) ** 2
        self.mean_s, self.variance = state.delay_s, state.delay_std_s**2

    def tell(self, delays: Array, spread: Array) -> None:
        """The filters' mixture of an image's delay, s, with variances, s^2; each (filters,)."""
        state, w = self._state, self._state.evidence.weights
        mean = float(w @ delays)
        variance = float(w @ (spread + (delays - mean) ** 2))
        state.delay_s, state.delay_std_s = mean, sqrt(variance + self._sampled_variance)
        if variance < (0.2 * state.frame_s) ** 2:
            late = mean - self.mean_s
            self.mean_s += 0.03 * late
            self.variance += 0.03 * (late * late - self.variance)
            self.variance = max(self.variance, 0.001**2)
