"""Whether images and accelerometer still agree on the scale of the image, which drifts as the scene's depth does.

A block of the accelerometer departs from what the filter expects by r, with the variance s of its innovation; where the
scale is off by d, by d times the expected value e besides. Over some seconds d is (sum r e / s) / (sum e^2 / s), and
sum r e / s over its own standard deviation is the score test of d = 0 (C. R. Rao, Proc. Cambridge Phil. Soc. 44,
1948): innovations of a filter that is right do not add up. Where they do, the scale is given room to walk as far as it
has gone. An accelerometer whose gain drifts looks the same, and is taken for a scene that does.
"""

from math import inf

_MEMORY_S = 10.0
_ALARM = 22.0  # of the score's square, which has mean 1: by chance once in fifty hours
_SOON_S = 4.0  # as far again
_FADE_S = 20.0  # what has drifted may go on
_MOST = 0.3  # a vibration so small that only this much shows is not what tells a drift
_BOUND = 9.0  # of one innovation squared: an impact or a spike may not decide alone


class ScaleWatch:
    """walk: growth of the variance of the scale's relative error, beyond what is assumed of it, 1/s."""

    def __init__(self) -> None:
        """In agreement."""
        self.begin()

    def begin(self) -> None:
        """In agreement: what was found was another trouble's doing."""
        self.walk = 0.0
        self._since_alarm_s = inf
        self.restart()

    def restart(self) -> None:
        """What was seen says nothing of what comes."""
        self._score = self._information = self._variance = 0.0

    def grown(self, elapsed_s: float) -> float:
        """By how much that variance grows within elapsed_s; the walk fades meanwhile, whatever is seen."""
        variance = self.walk * elapsed_s
        self.walk -= variance / _FADE_S
        self._since_alarm_s += elapsed_s
        return variance

    @property
    def drifts(self) -> bool:
        """Whether the scale has been found to be off lately."""
        return self._since_alarm_s < _FADE_S

    def see(self, difference_m: float, expected_m: float, variance: float, elapsed_s: float) -> bool:
        """A block's departure from what was expected, that, the departure's variance, m^2, and the block's length.

        Returns whether the scale has just been found to be off.
        """
        if difference_m * difference_m > _BOUND * variance:
            return False
        keep, weight = 1.0 - elapsed_s / _MEMORY_S, expected_m / variance
        self._score = keep * self._score + weight * difference_m
        self._information = keep * self._information + weight * expected_m
        self._variance = keep * keep * self._variance + weight * expected_m
        if self._score * self._score <= _ALARM * self._variance:
            return False
        error = self._score / self._information
        self.restart()
        if abs(error) > _MOST:
            return False
        self.walk = max(self.walk, error * error / _SOON_S)
        self._since_alarm_s = 0.0
        return True
