"""Intensities of the states' walks, learnt from the movement of their estimates.

Implements Eqs. 44, 45, 47 of docs/fused.md.

Over any stretch of time the estimate's own step has the variance P(start) - P(end) + q T if the walk's q is right,
since that step is orthogonal to what is still unknown at its end (after R. K. Mehra, On the identification of
variances and adaptive Kalman filtering, IEEE Trans. Automatic Control 15, 1970). Smaller steps: q is too large.
"""

from math import exp

import numpy as np
from numpy.typing import NDArray

from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions
from stillarm.controller.estimation.fused.filters.bank import FilterBank
from stillarm.controller.estimation.fused.filters.laws import LAWS, Law


class LearntWalk:
    """share: of the variance that a walk was assumed to grow by, how much it does."""

    def __init__(
        self,
        rate: float | None = None,
        most: float | None = None,
        least: float | None = None,
        assumed: Assumptions = ASSUMPTIONS,
    ) -> None:
        """As assumed. rate: of the share's logarithm, for each stretch; least, most: the share's bounds."""
        self._assumed = assumed.walks
        self.share = 1.0
        self._rate = self._assumed.rate if rate is None else rate
        self._most = self._assumed.most_share if most is None else most
        self._least = self._assumed.least_share if least is None else least
        self._value = self._variance = 0.0
        self._begun = False

    def forget(self) -> None:
        """Drop the stretch under way: something else has moved the estimate."""
        self._begun = False

    def see(self, value: float, variance: float, assumed: float) -> None:
        """The estimate at the end of a stretch, where the next begins; assumed: the walk's variance over it.

        The share falls to half at most; a step of three deviations makes it a hundred times larger.
        """
        walked = self.share * assumed
        expected = self._variance - variance + walked
        step = value - self._value
        begun, self._begun = self._begun, True
        self._value, self._variance = value, variance
        if not begun or expected <= self._assumed.least_expected * walked:
            return
        nis = min(step * step / expected, self._assumed.largest_nis)
        told = min(walked / expected, 1.0)  # the rest of the step is what was learnt of where it began
        grown = self.share * exp(self._rate * told * (nis - 1.0))
        self.share = min(max(grown, self._least), self._most)


class LearntWander:
    """How fast the delay wanders by a law that dates frames by their arrival, by its quiet filter while it is believed.

    share: of the walk's variance assumed, and of the rate at which it comes back to its mean: its spread stays.
    """

    def __init__(
        self,
        at: Layout,
        law: Law,
        shift_noise: NDArray[np.float64],
        shift_return: NDArray[np.float64],
        assumed: Assumptions = ASSUMPTIONS,
    ) -> None:
        """As assumed; law: DRIFT, which wanders within some frames, or STEADY, which hardly does.

        shift_noise: growth of the shift's variance, s^2/s; shift_return: rate at which it comes back, 1/s; both
        (filters,) and kept in step for that law.
        """
        walks = assumed.walks
        self._shift, self._law, self._noise, self._return = at.shift, law, shift_noise, shift_return
        self._nominal = float(shift_noise[law]), float(shift_return[law])
        drifts = law is Law.DRIFT
        self._stretch_s = walks.wander_stretch_s if drifts else walks.stretch_s
        self._walk = (
            LearntWalk(walks.wander_rate, walks.most_wander, assumed=assumed)
            if drifts
            else LearntWalk(assumed=assumed)
        )
        self._since_s = float("-inf")
        self._moved = -1

    @property
    def share(self) -> float:
        return self._walk.share

    def see(self, bank: FilterBank, law: int) -> None:
        """After an image; law: that is believed."""
        own = self._law
        if law != own:
            self._walk.forget()
            return
        elapsed_s = bank.edge_s - self._since_s
        if elapsed_s < self._stretch_s:
            return
        self._since_s = bank.edge_s
        if bank.moved[own] != self._moved or elapsed_s > 2.0 * self._stretch_s:
            self._moved = bank.moved[own]
            self._walk.forget()
        shift, (noise, back) = self._shift, self._nominal
        self._walk.see(float(bank.x[own, shift]), float(bank.p[own, shift, shift]), noise * elapsed_s)
        self._noise[own::LAWS] = self.share * noise
        self._return[own::LAWS] = self.share * back


class LearntWalks:
    """Those of frequency and decay, and of n_i's lead, by the quiet filter of the law that is believed.

    lead: of n_i, where no clock dates the frames.
    """

    def __init__(
        self, at: Layout, state_noise: NDArray[np.float64], filters: int, assumed: Assumptions = ASSUMPTIONS
    ) -> None:
        """state_noise: growth of the variances, per s, (filters, n); kept in step for the first `filters`."""
        self._assumed = assumed.walks
        self._at, self._noise, self._filters = at, state_noise, filters
        self._places = range(at.frequency.start, at.decay.stop)
        self._nominal: list[float] = state_noise[0, at.frequency.start : at.decay.stop].tolist()
        self._walks = [LearntWalk(assumed=assumed) for _ in self._nominal]
        self.lead = LearntWalk(assumed=assumed)
        self._since_s = float("-inf")
        self._whose = -1, -1  # filter, and how often it had been moved

    def see(self, bank: FilterBank, law: int, lead_walk: float) -> None:
        """After an image; law: that is believed; lead_walk: growth of the variance assumed of n_i's lead, s^2/s."""
        elapsed_s = bank.edge_s - self._since_s
        if elapsed_s < self._assumed.stretch_s:
            return
        self._since_s = bank.edge_s
        whose = law, bank.moved[law]
        if whose != self._whose:
            self.forget()
            self._whose = whose
        values, variances = bank.x[law].tolist(), bank.p[law].diagonal().tolist()
        for place, walk, assumed in zip(self._places, self._walks, self._nominal, strict=True):
            walk.see(values[place], variances[place], assumed * elapsed_s)
            self._noise[: self._filters, place] = walk.share * assumed
        if lead_walk > 0.0:
            ahead = self._at.ahead
            self.lead.see(values[ahead], variances[ahead], lead_walk * elapsed_s)
        else:
            self.lead.forget()

    def allow_as_assumed(self) -> None:
        """Walks of frequency and decay as assumed, or more where more was learnt, until the next is learnt."""
        self._noise[: self._filters, self._places.start : self._places.stop] = [
            max(walk.share, 1.0) * one for walk, one in zip(self._walks, self._nominal, strict=True)
        ]
        self.forget()

    def forget(self) -> None:
        """The stretch under way is of no use."""
        for walk in (*self._walks, self.lead):
            walk.forget()
