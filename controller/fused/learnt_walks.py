"""How far quantities walk that are given room to walk, learnt from how far their estimates have gone.

Over any stretch of time the estimate's own step has the variance P(start) - P(end) + q T if the walk's q is right,
since that step is orthogonal to what is still unknown at its end (after R. K. Mehra, On the identification of
variances and adaptive Kalman filtering, IEEE Trans. Automatic Control 15, 1970). Smaller steps: q is too large.
"""

from math import exp

import numpy as np
from numpy.typing import NDArray

from controller.fused.bank import FilterBank
from controller.fused.layout import Layout

_STRETCH_S = 1.5
_LEAST_SHARE, _MOST_SHARE = 0.04, 900.0  # of the variance: a fifth of the deviation, and thirty times it
_RATE = 0.3  # of the share's logarithm, for each stretch
_MOST_SURPRISE = 9.0
_LEAST_EXPECTED = 0.2  # of the walk's variance: less comes of a filter that was not measured


class LearntWalk:
    """share: of the variance that a walk was assumed to grow by, how much it does."""

    def __init__(self) -> None:
        """As assumed."""
        self.share = 1.0
        self._value = self._variance = 0.0
        self._begun = False

    def forget(self) -> None:
        """The stretch under way is of no use: something else has moved the estimate."""
        self._begun = False

    def see(self, value: float, variance: float, assumed: float) -> None:
        """The estimate at the end of a stretch, where the next begins; assumed: the walk's variance over it.

        The share falls by a quarter at most; a step of three deviations makes it eleven times larger.
        """
        walked = self.share * assumed
        expected = self._variance - variance + walked
        step = value - self._value
        begun, self._begun = self._begun, True
        self._value, self._variance = value, variance
        if not begun or expected <= _LEAST_EXPECTED * walked:
            return
        surprise = min(step * step / expected, _MOST_SURPRISE)
        told = min(walked / expected, 1.0)  # the rest of the step is what was learnt of where it began
        grown = self.share * exp(_RATE * told * (surprise - 1.0))
        self.share = min(max(grown, _LEAST_SHARE), _MOST_SHARE)


class LearntWalks:
    """Those of frequency and decay, and of n_i's lead, by the quiet filter of the law that is believed.

    lead: of n_i, where no clock dates the frames.
    """

    def __init__(self, at: Layout, state_noise: NDArray[np.float64], filters: int) -> None:
        """state_noise: growth of the variances, per s, (filters, n); kept in step for the first `filters`."""
        self._at, self._noise, self._filters = at, state_noise, filters
        self._places = range(at.frequency.start, at.decay.stop)
        self._assumed: list[float] = state_noise[0, at.frequency.start : at.decay.stop].tolist()
        self._walks = [LearntWalk() for _ in self._assumed]
        self.lead = LearntWalk()
        self._since_s = float("-inf")
        self._whose = -1, -1  # filter, and how often it had been moved

    def see(self, bank: FilterBank, law: int, lead_walk: float) -> None:
        """After an image; law: that is believed; lead_walk: growth of the variance assumed of n_i's lead, s^2/s."""
        elapsed_s = bank.edge_s - self._since_s
        if elapsed_s < _STRETCH_S:
            return
        self._since_s = bank.edge_s
        whose = law, bank.moved[law]
        if whose != self._whose:
            self.forget()
            self._whose = whose
        values, variances = bank.x[law].tolist(), bank.p[law].diagonal().tolist()
        for place, walk, assumed in zip(self._places, self._walks, self._assumed, strict=True):
            walk.see(values[place], variances[place], assumed * elapsed_s)
            self._noise[: self._filters, place] = walk.share * assumed
        if lead_walk > 0.0:
            ahead = self._at.ahead
            self.lead.see(values[ahead], variances[ahead], lead_walk * elapsed_s)
        else:
            self.lead.forget()

    def allow(self, share: float) -> None:
        """Walks of frequency and decay as assumed, times that share of their variance, until the next is learnt."""
        self._noise[: self._filters, self._places.start : self._places.stop] = [
            share * one for one in self._assumed
        ]
        self.forget()

    def forget(self) -> None:
        """The stretch under way is of no use."""
        for walk in (*self._walks, self.lead):
            walk.forget()
