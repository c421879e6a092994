"""A stretch of cycles on the loop's own schedule. Without work it is the bare timer, which is the floor."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from stillarm.controller.loop.schedule import CycleClock
from stillarm.controller.statistics.histogram import MicrosecondHistogram

_LEAD_CYCLES = 3


@dataclass
class Measured:
    """The sum of all slices of one kind."""

    lateness: MicrosecondHistogram = field(default_factory=MicrosecondHistogram)
    compute: MicrosecondHistogram = field(default_factory=MicrosecondHistogram)
    cycles: int = 0
    misses: int = 0

    def result(self) -> dict[str, Any]:
        """Wake-up latency, misses and cycles, by the names of the benchmark's file."""
        return {
            "wakeup_latency_us": by_name(self.lateness.summary()),
            "deadline_misses": self.misses,
            "cycles": self.cycles,
        }


def by_name(summary: tuple[float, float, float, float]) -> dict[str, float]:
    """The four numbers of a histogram's summary by name."""
    return dict(zip(("p50", "p99", "p999", "max"), summary, strict=True))


def run_slice(
    measured: Measured, duration_s: float, cycle_s: float, work: Callable[[], None] | None = None
) -> None:
    """Wake at every cycle for a while; do the work, if any."""
    now = time.monotonic
    clock = CycleClock(cycle_s, now() + _LEAD_CYCLES * cycle_s)
    cycle = clock.start()
    last = cycle + round(duration_s / cycle_s)  # a late start does not shorten the slice
    while cycle < last:
        woke = now()
        measured.lateness.add(woke - clock.origin_s - cycle * cycle_s)
        if work is not None:
            work()
            measured.compute.add(now() - woke)
        measured.cycles += 1
        cycle = clock.wait(cycle)
    measured.misses += clock.misses
