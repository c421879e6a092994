"""How long a diagnosis may take, and how much of a long recording that suffices for.

A stage that runs out of time is abandoned, and the verdict stands on the stages before it.
"""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from math import inf

from stillarm.diagnosis.physics.computing import Clock, limited
from stillarm.diagnosis.physics.world import World

VERDICT_S = 5.0  # for what is left, the tables and the report's drawings, of one minute at 1 kHz on one core
VERDICT_SHARE = 0.18  # of the budget, where that is more: a machine may be slower, or busy
MIN_STAGES_SHARE = 0.4  # of a budget too small for either
# simulations in a baseline and a round of the search, the median of the table in docs/diagnosis.md
RUNS = 700
_TIMED = 3  # simulations, of which the quickest counts: another process may take the processor meanwhile
MIN_S = 10.0  # less than that shows hardly any vibration; a smaller budget stops between stages


@dataclass(frozen=True)
class Budget:
    """Seconds that a diagnosis may take, counted from began_s of a monotonic clock; none: as long as it needs."""

    seconds: float | None
    began_s: float
    clock: Clock = time.monotonic

    @property
    def used_s(self) -> float:
        """Time since the beginning, s."""
        return self.clock() - self.began_s

    @property
    def left_s(self) -> float | None:
        """Time that is left, s; None where there is no limit."""
        return None if self.seconds is None else self.seconds - self.used_s

    @property
    def stages_s(self) -> float:
        """What all stages before the verdict may take, s; the rest is for the verdict and the report."""
        whole = inf if self.seconds is None else self.seconds
        return max(min(whole - VERDICT_S, (1.0 - VERDICT_SHARE) * whole), MIN_STAGES_SHARE * whole)

    @contextmanager
    def limit(self, share: float = 1.0, since_s: float = 0.0) -> Iterator[None]:
        """Within it, `check_time` raises OutOfTime once this share of what the stages may take is used, counted from
        since_s after the beginning: starting and reading take their time on a busy machine."""
        at = None
        if self.seconds is not None:
            at = self.began_s + since_s + share * max(self.stages_s - since_s, 0.0)
        with limited(at, self.clock):
            yield


def unlimited() -> Budget:
    """As long as it needs, from now on."""
    return Budget(None, time.monotonic())


def affordable(world: World, budget: Budget) -> float:
    """Seconds of the recording, from its start on, that can be diagnosed in what is left of the budget; all of them
    where there is no limit. Measured by simulations of the recording."""
    left_s, duration_s = budget.left_s, world.measured.duration_s
    if left_s is None or duration_s <= MIN_S:
        return duration_s
    vector = world.space.vector()
    world.predict(vector)  # compiles, where nothing has yet
    times_s = [budget.clock()]
    for _ in range(_TIMED):
        world.predict(vector)
        times_s.append(budget.clock())
    needed_s = RUNS * min(end - begin for begin, end in pairwise(times_s))
    stages_s = max(budget.stages_s - budget.used_s, 0.0)
    return min(duration_s, max(MIN_S, duration_s * stages_s / max(needed_s, 1e-9)))
