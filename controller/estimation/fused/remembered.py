"""What the filters knew when all was well: the alternative to what a disturbance has taught them.

A pull, a push, or images that came in disorder may teach the filters another frequency, scale, or date. If the last
images are explained by a vibration with all of that as it was before, nothing of it has changed (an alternative that
was not led astray; docs/fused.md, section 9).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_EACH_S = 1.0  # a state is kept so often
_PROVEN_S = 1.5  # later, if all has been well since, it is what is remembered
_DIFFERS_STDS = 4.0


@dataclass(frozen=True)
class Knowledge:
    """States x (filters, n), covariances p (filters, n, n), and logarithms of the filters' probabilities, (filters,),
    at time_s."""

    time_s: float
    x: Array
    p: Array
    log_weights: Array


class Remembered:
    """known: what was known when all was well, None if it never was or no longer holds."""

    def __init__(self) -> None:
        """Nothing."""
        self.forget()

    def forget(self) -> None:
        """Dates, or what they count from, have changed."""
        self.known: Knowledge | None = None
        self._pending: Knowledge | None = None

    def trouble(self) -> None:
        """Something is not well: what was kept lately may be wrong already."""
        self._pending = None

    def calm(self, time_s: float, x: Array, p: Array, log_weights: Array) -> None:
        """All is well: keep what is known now, and trust what was kept a while ago."""
        if self._pending is not None and time_s - self._pending.time_s > _PROVEN_S:
            self.known, self._pending = self._pending, None
        if self._pending is None and (self.known is None or time_s - self.known.time_s > _EACH_S):
            self._pending = Knowledge(time_s, x.copy(), p.copy(), log_weights.copy())

    def differs(self, x: Array, states: list[int]) -> bool:
        """Whether the state (n,) of the most likely filter is none that was likely then. states: to be compared."""
        known = self.known
        if known is None:
            return False
        best = int(known.log_weights.argmax())
        variance = known.p[best][states, states]
        return bool(np.any((x[states] - known.x[best][states]) ** 2 > _DIFFERS_STDS**2 * variance))
