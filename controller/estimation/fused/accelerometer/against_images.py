"""The accelerometer compared with the images: its gain, its offset, and how far it contradicts them.

Implements Eq. 13 of docs/fused.md.

Weighted regression of the blocks' values on the values that the images predict, over about the last period: value =
gain expected + offset. Forgetting is exponential, so that all three follow a change within a second.
"""

from math import inf, sqrt

from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions


class AgainstImages:
    """Gain with its standard deviation, offset, m, with its own, and strain: mean normalised difference squared."""

    def __init__(self, assumed: Assumptions = ASSUMPTIONS) -> None:
        """Nothing compared yet."""
        self._assumed = assumed.against_images
        self.gain, self.gain_std = 1.0, inf
        self.offset, self.offset_std = 0.0, inf
        self.strain = 1.0
        self.forget_offset()

    def forget_offset(self) -> None:
        """Restart the regression: the offset has been corrected."""
        self._count = self._w = self._x = self._y = self._xx = self._xy = 0.0

    def see(self, value_m: float, expected_m: float, variance: float) -> None:
        """Process a block's mean, without bias, and the value that images predict for it; variance: of their
        difference, m^2."""
        keep, weight = 1.0 - 1.0 / self._assumed.memory_blocks, 1.0 / variance
        self._count = keep * self._count + 1.0
        difference = value_m - expected_m
        nis = min(difference * difference * weight, self._assumed.largest_nis)
        self.strain += (nis - self.strain) / self._assumed.memory_blocks
        self._w = keep * self._w + weight
        self._x = keep * self._x + weight * expected_m
        self._y = keep * self._y + weight * value_m
        self._xx = keep * self._xx + weight * expected_m * expected_m
        self._xy = keep * self._xy + weight * expected_m * value_m
        self.gain_std = self.offset_std = inf
        if self._count < self._assumed.few_blocks:
            return
        self.offset, self.offset_std = (self._y - self._x) / self._w, 1.0 / sqrt(self._w)
        spread = self._xx - self._x * self._x / self._w
        if spread > 0.0:
            self.gain = (self._xy - self._x * self._y / self._w) / spread
            self.gain_std = 1.0 / sqrt(spread)
