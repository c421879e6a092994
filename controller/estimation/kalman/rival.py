"""A second filter that starts at an impact, and replaces the first if it predicts the following images better.

The filter assumes that an impact changes the vibration and leaves the image zero unchanged. The release of a held arm,
or a moved zero, violates this: the filter then explains a constant by one impact after another. The following images
decide which it was, by the sum of their log predictive densities, from the time at which the rival has determined
vibration and zero until at most a period later (prequential analysis: A. P. Dawid, J. Roy. Stat. Soc. A 147, 1984).
"""

from stillarm.controller.estimation.kalman.belief import Belief

_ODDS = 5.0  # nats: 150 to 1, since impacts are far more frequent than a moved zero
_CLEAR_ODDS = 20.0  # nats: decides before the period's end
_LEAST_IMAGES = 6  # fewest images for a decision
_LARGEST_LOSS = 12.5  # nats, of one image, so that an outlier does not decide


class Rival:
    """A filter restarted at an impact. It settles for half a period and is compared for a period."""

    def __init__(self, belief: Belief, next_cycle: int, settled_s: float, period_s: float) -> None:
        """belief: after its first image. next_cycle: of the fast sensor. settled_s: time until the comparison."""
        self.belief = belief
        self.next_cycle = next_cycle
        self.began_s = belief.time_s
        self._from_s = belief.time_s + settled_s
        self._until_s = self._from_s + period_s
        self._lead = 0.0
        self._images = 0

    def see(self, belief: Belief, incumbent: Belief) -> None:
        """Compare both beliefs after the same image."""
        self.belief = belief
        if belief.time_s >= self._from_s:
            self._lead += max(belief.log_density, -_LARGEST_LOSS) - max(incumbent.log_density, -_LARGEST_LOSS)
            self._images += 1

    @property
    def decided(self) -> bool:
        """Whether the comparison is complete."""
        over = self.belief.time_s >= self._until_s or self._lead > _CLEAR_ODDS
        return over and self._images >= _LEAST_IMAGES

    @property
    def wins(self) -> bool:
        """Whether the rival replaces the other filter."""
        return self.decided and self._lead > _ODDS
