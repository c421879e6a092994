"""The stated delay of an image, and the mean delay of images.

Implements Eq. 36 of docs/fused.md.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.controller.estimation.fused.fusion.state import FusionState

Array = NDArray[np.float64]


class ImageDelay:
    """mean_s, variance: of capture delays that were known to a part of a frame, s and s^2."""

    def __init__(self, state: FusionState) -> None:
        """Start from the model's mean and spread."""
        self._state, self._assumed = state, state.assumed.update
        self._sampled_variance = state.sampled_s**2
        self.mean_s, self.variance = state.delay_s, state.delay_std_s**2

    def tell(self, delays: Array, spread: Array) -> None:
        """The filters' mixture of an image's delay, s, with variances, s^2; each (filters,)."""
        state, w = self._state, self._state.evidence.weights
        mean = float(w @ delays)
        variance = float(w @ (spread + (delays - mean) ** 2))
        state.delay_s, state.delay_std_s = mean, sqrt(variance + self._sampled_variance)
        if variance < (self._assumed.delay_known * state.frame_s) ** 2:
            late = mean - self.mean_s
            gain = self._assumed.delay_gain
            self.mean_s += gain * late
            self.variance += gain * (late * late - self.variance)
            self.variance = max(self.variance, self._assumed.least_delay_std_s**2)
