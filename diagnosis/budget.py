"""How long a diagnosis may take: a limit that the simulation itself checks, so that no stage outlasts it.

A stage that runs out of time is abandoned, and the verdict stands on the stages before it. The limit is a context
variable: it holds for one diagnosis, also where several run in threads of one process.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from math import inf

Clock = Callable[[], float]

VERDICT_S = 5.0  # for what is left, the tables and the report's drawings, of one minute at 1 kHz on one core
VERDICT_SHARE = 0.25  # of the budget, where that is more: a machine may be slower, or busy
MIN_STAGES_SHARE = 0.4  # of a budget too small for either


class OutOfTime(Exception):
    """The stage's time is over. Never reaches the user: who set the limit catches it."""


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
        token = _ends.set(None if at is None else (at, self.clock))
        try:
            yield
        finally:
            _ends.reset(token)


def unlimited() -> Budget:
    """As long as it needs, from now on."""
    return Budget(None, time.monotonic())


_ends: ContextVar[tuple[float, Clock] | None] = ContextVar("diagnosis_ends", default=None)


def check_time() -> None:
    """Raise OutOfTime where a limit is set and has passed."""
    end = _ends.get()
    if end is not None and end[1]() > end[0]:
        raise OutOfTime
