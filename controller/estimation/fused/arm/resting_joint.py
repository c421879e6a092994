"""Whether the joint rests: the encoder's noise is no motion of the arm.

Implements Eq. 8 of docs/fused.md.

An image's scale and instant are learnt from what the joint's motion shows in it. The noise of an encoder, times the
arm's length, may well exceed that of an image. If it counted as motion, the filters would learn that images show none
of it: a scale that tends to zero (errors in variables; Fuller, Measurement Error Models, 1987, section 1.1). So the
position is held at its mean while a short mean stays near to it.
"""

from collections import deque
from math import sqrt

from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions


class RestingJoint:
    """Decides cycle by cycle. resting: whether the joint stands still. held_rad: where, if so.

    recent: the last positions, rad, the newest last.
    """

    def __init__(self, assumed: Assumptions = ASSUMPTIONS) -> None:
        """Nothing seen: the joint is taken to move."""
        self._assumed = assumed.joint
        # variance of the difference of both means, by the noise's
        self._of_departure = 1.0 / self._assumed.short_cycles + 1.0 / self._assumed.rest_cycles
        self.recent: deque[float] = deque(maxlen=self._assumed.rest_cycles)
        self._short_sum = self._long_sum = 0.0
        self._calm = 0
        self.resting = False
        self.held_rad = 0.0

    def see(self, position_rad: float, noise_variance: float) -> bool:
        """Process a cycle's position, with the variance of the encoder's noise, rad^2; whether rest began or ended."""
        recent, assumed = self.recent, self._assumed
        count, long, short = len(recent), assumed.rest_cycles, assumed.short_cycles
        if count == long:
            self._long_sum -= recent[0]
        if count >= short:
            self._short_sum -= recent[-short]
        recent.append(position_rad)
        self._short_sum += position_rad
        self._long_sum += position_rad
        if count + 1 < long:
            return False
        place = self.held_rad if self.resting else self._long_sum / long
        departure = self._short_sum / short - place
        if (
            abs(departure)
            > assumed.moved_stds * sqrt(noise_variance * self._of_departure) + assumed.least_rad
        ):
            was, self.resting, self._calm = self.resting, False, 0
            return was
        if self.resting:
            self.held_rad += assumed.slow_share * departure
            return False
        self._calm += 1
        self.resting = self._calm >= long
        if self.resting:
            self.held_rad = self._long_sum / long
        return self.resting
