"""Whether the joint rests: the encoder's noise is no motion of the arm.

An image's scale and instant are learnt from what the joint's motion shows in it. The noise of an encoder, times the
arm's length, may well exceed that of an image. Taken for motion, it would teach that images show none of it: a scale
that tends to zero (errors in variables; Fuller, Measurement Error Models, 1987, section 1.1). So the position is held
at its mean while a short mean stays near to it.
"""

from collections import deque
from math import sqrt

_SHORT_CYCLES = 16  # the mean that is compared with the position held
_REST_CYCLES = 64  # without a sign of motion; the position held then is their mean
_OF_DEPARTURE = (
    1.0 / _SHORT_CYCLES + 1.0 / _REST_CYCLES
)  # variance of the difference of both means, by the noise's
_SIGNIFICANT = 5.0  # standard deviations of that: by chance once in a day
_SLOW_SHARE = (
    0.002  # of a resting joint's drift, a cycle: thermal drift and creep are followed within half a second
)
_LEAST_RAD = 1e-9


class RestingJoint:
    """Decides cycle by cycle. resting: whether the joint stands still. held_rad: where, if so.

    recent: the last positions, rad, the newest last.
    """

    def __init__(self) -> None:
        """Nothing seen: the joint is taken to move."""
        self.recent: deque[float] = deque(maxlen=_REST_CYCLES)
        self._short_sum = self._long_sum = 0.0
        self._calm = 0
        self.resting = False
        self.held_rad = 0.0

    def see(self, position_rad: float, noise_variance: float) -> bool:
        """Take in a cycle's position, with the variance of the encoder's noise, rad^2; whether rest began or ended."""
        recent = self.recent
        if len(recent) == _REST_CYCLES:
            self._long_sum -= recent[0]
        if len(recent) >= _SHORT_CYCLES:
            self._short_sum -= recent[-_SHORT_CYCLES]
        recent.append(position_rad)
        self._short_sum += position_rad
        self._long_sum += position_rad
        if len(recent) < _REST_CYCLES:
            return False
        place = self.held_rad if self.resting else self._long_sum / _REST_CYCLES
        departure = self._short_sum / _SHORT_CYCLES - place
        if abs(departure) > _SIGNIFICANT * sqrt(noise_variance * _OF_DEPARTURE) + _LEAST_RAD:
            was, self.resting, self._calm = self.resting, False, 0
            return was
        self._calm = min(self._calm + 1, _REST_CYCLES)
        if self.resting:
            self.held_rad += _SLOW_SHARE * departure
            return False
        self.resting = self._calm >= _REST_CYCLES
        if self.resting:
            self.held_rad = self._long_sum / _REST_CYCLES
        return self.resting
