"""Whether images and accelerometer still agree on the scale of the image, which drifts as the scene's depth does.

Implements Eqs. 45, 52, 53 of docs/fused.md.

A block of the accelerometer departs from what the filter expects by r, with the variance s of its innovation; where the
scale is off by d, by d times the expected value e besides. Over some seconds d is (sum r e / s) / (sum e^2 / s), and
sum r e / s over its own standard deviation is the score test of d = 0 (C. R. Rao, Proc. Cambridge Phil. Soc. 44, 1948):
innovations of a filter that is right do not add up. Where they do, the scale is given room to walk as far as it has
gone. An accelerometer whose gain drifts looks the same, and counts as a drifting scene. A force in time with the
vibration, which the two do not show alike, raises the alarm, too: the room is taken back as fast as the scale's
estimate turns out not to use it (learnt_walks.py).
"""

from math import inf

from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions
from stillarm.controller.estimation.fused.learning.learnt_walks import LearntWalk


class ScaleWatch:
    """walk: growth of the variance of the scale's relative error, beyond what is assumed of it, 1/s."""

    def __init__(self, assumed: Assumptions = ASSUMPTIONS) -> None:
        """In agreement."""
        self._assumed, self._all_assumed = assumed.scale, assumed
        self.begin()

    def begin(self) -> None:
        """In agreement: what was found was another trouble's doing."""
        self.walk = 0.0
        self._since_alarm_s = inf
        self._give_room()
        self.restart()

    def _give_room(self) -> None:
        """The scale's steps have yet to be seen."""
        self._learnt = LearntWalk(most=1.0, least=self._assumed.least_room, assumed=self._all_assumed)
        self._stretch_s = self._room = 0.0
        self._whose = -1, -1

    def restart(self) -> None:
        """What was seen says nothing of what comes."""
        self._score = self._information = self._variance = 0.0

    def grown(self, elapsed_s: float) -> float:
        """Growth of that variance within elapsed_s. The walk fades meanwhile, whatever is measured."""
        variance = self.walk * elapsed_s
        self.walk -= variance / self._assumed.fade_s
        self._since_alarm_s += elapsed_s
        self._stretch_s += elapsed_s
        self._room += variance / self._learnt.share
        return variance

    def see_scale(self, error: float, variance: float, whose: tuple[int, int]) -> None:
        """After an image: whether the scale uses the room it was given. error, variance: the scale's relative error by
        a filter; whose: that filter, and how often it was moved otherwise than by what it saw."""
        if self.walk == 0.0 or self._stretch_s < self._assumed.room_stretch_s:
            return
        if whose != self._whose:
            self._learnt.forget()
            self._whose = whose
        share = self._learnt.share
        self._learnt.see(error, variance, self._room)
        self.walk *= self._learnt.share / share
        self._stretch_s = self._room = 0.0

    @property
    def drifts(self) -> bool:
        """Whether the scale has been found to be off lately."""
        return self._since_alarm_s < self._assumed.fade_s

    def see(self, difference_m: float, expected_m: float, variance: float, elapsed_s: float) -> bool:
        """A block's departure from what was expected, that, the departure's variance, m^2, and the block's length.

        Returns whether the scale has just been found to be off.
        """
        if difference_m * difference_m > self._assumed.bound * variance:
            return False
        keep, weight = 1.0 - elapsed_s / self._assumed.memory_s, expected_m / variance
        self._score = keep * self._score + weight * difference_m
        self._information = keep * self._information + weight * expected_m
        self._variance = keep * keep * self._variance + weight * expected_m
        if self._score * self._score <= self._assumed.alarm * self._variance:
            return False
        error = self._score / self._information
        self.restart()
        if abs(error) > self._assumed.most:
            return False
        self.walk = max(self.walk, error * error / self._assumed.soon_s)
        self._give_room()
        self._since_alarm_s = 0.0
        return True
