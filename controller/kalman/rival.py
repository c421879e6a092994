"""A second filter that begins where the first was surprised, and takes its place if it foretells the images better.

A blow changes the vibration and leaves the image's zero where it was, and that is how the filter takes a surprise. What
lets go of the arm after holding it, or moves the zero, does not: the filter then explains a constant by ever new blows.
Which it was is decided by the images that follow: by the sum of the logarithms of their predictive densities, from when
the rival knows vibration and zero until a period later at most (prequential analysis: A. P. Dawid, J. Roy. Stat. Soc.
A 147, 1984).
"""

from collections.abc import Callable

from controller.kalman.belief import Belief

Correct = Callable[[Belief], Belief]

_ODDS = 5.0  # of logarithm: 150 to 1, for an arm that is struck far oftener than its zero moves
_CLEAR_ODDS = 20.0  # no need to wait for the period's end
_LEAST_IMAGES = 6
_LARGEST_LOSS = 12.5  # of one image: an outlier is not to decide


class Rival:
    """Begun anew at a surprise; watched for half a period and a period."""

    def __init__(self, belief: Belief, next_cycle: int, settled_s: float, period_s: float) -> None:
        """belief: after its first image. next_cycle: of the fast sensor. settled_s: from when on it is compared."""
        self.belief = belief
        self.next_cycle = next_cycle
        self.began_s = belief.time_s
        self._from_s = belief.time_s + settled_s
        self._until_s = self._from_s + period_s
        self._lead = 0.0
        self._images = 0

    def see(self, belief: Belief, incumbent: Belief) -> None:
        """Both after the same image."""
        self.belief = belief
        if belief.time_s >= self._from_s:
            self._lead += max(belief.log_density, -_LARGEST_LOSS) - max(incumbent.log_density, -_LARGEST_LOSS)
            self._images += 1

    @property
    def decided(self) -> bool:
        """Whether enough has been seen."""
        over = self.belief.time_s >= self._until_s or self._lead > _CLEAR_ODDS
        return over and self._images >= _LEAST_IMAGES

    @property
    def wins(self) -> bool:
        """Whether it is to take the other's place."""
        return self.decided and self._lead > _ODDS
