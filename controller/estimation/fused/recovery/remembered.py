"""The last state in which the filters were consistent: the alternative to what a disturbance has taught them.

Implements Eq. 63 of docs/fused.md.

A pull, a push, or images that came in disorder may teach the filters another frequency, scale, or date. If the last
images are explained by a vibration with all of that as it was before, nothing of it has changed (an alternative that
was not led astray).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions

Array = NDArray[np.float64]


@dataclass
class Knowledge:
    """States x (filters, n), covariances p (filters, n, n), and logarithms of the filters' probabilities, (filters,),
    at time_s."""

    time_s: float
    x: Array
    p: Array
    log_weights: Array

    def take(self, time_s: float, x: Array, p: Array, log_weights: Array) -> None:
        """Hold these instead."""
        self.time_s = time_s
        self.x[:], self.p[:], self.log_weights[:] = x, p, log_weights


class Remembered:
    """Keeps two states of the bank, in memory that is taken once."""

    def __init__(self, assumed: Assumptions = ASSUMPTIONS) -> None:
        """Nothing."""
        self._assumed = assumed.fresh_start
        self._kept: list[Knowledge] = []  # what is known, and what has yet to prove well
        self.forget()

    def forget(self) -> None:
        """Dates, or what they count from, have changed."""
        self._is_known = self._is_pending = False

    def trouble(self) -> None:
        """Drop the latest stored state: the filters are no longer consistent, and it may be wrong already."""
        self._is_pending = False

    @property
    def known(self) -> Knowledge | None:
        """What was known when all was well; None if it never was, or no longer holds."""
        return self._kept[0] if self._is_known else None

    def calm(self, time_s: float, x: Array, p: Array, log_weights: Array) -> None:
        """Store the present state, and trust the one stored a while ago: the filters are consistent."""
        if not self._kept:
            self._kept = [Knowledge(time_s, x.copy(), p.copy(), log_weights.copy()) for _ in range(2)]
        if self._is_pending and time_s - self._kept[1].time_s > self._assumed.proven_s:
            self._kept.reverse()
            self._is_known, self._is_pending = True, False
        if not self._is_pending and (
            not self._is_known or time_s - self._kept[0].time_s > self._assumed.each_s
        ):
            self._kept[1].take(time_s, x, p, log_weights)
            self._is_pending = True

    def differs(self, x: Array, states: list[int]) -> bool:
        """Whether the state (n,) of the most likely filter is none that was likely then. states: to be compared."""
        known = self.known
        if known is None:
            return False
        best = int(known.log_weights.argmax())
        variance = known.p[best][states, states]
        return bool(
            np.any((x[states] - known.x[best][states]) ** 2 > self._assumed.differs_stds**2 * variance)
        )
