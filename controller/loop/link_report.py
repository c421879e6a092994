"""The message about the link, once a second, assembled over several cycles.

With cold caches its parts take 130 us together: counters of the kernel, of each socket, of the clock estimate, and
their encoding. With one part a cycle, all cycles take equally long.
"""

from collections.abc import Callable, Iterator
from typing import Protocol

from stillarm.common.recorder.recorder_client import RecorderClient
from stillarm.common.recording.topics import TOPIC_INDEX, LinkSample
from stillarm.controller.loop.schedule import CycleClock
from stillarm.controller.statistics.loop_block import LoopBlock
from stillarm.controller.statistics.overrun import ThreadCounters

_EVERY_S = 1.0
_LINK = TOPIC_INDEX["/link"]


class LinkCounters(Protocol):
    """The part of the devices' interface that is used here."""

    @property
    def link_counts(self) -> dict[str, int]:
        """Counts of the visual datagrams, by name."""

    def link_status(self) -> dict[str, float]:
        """The other fields of /link, by name."""

    @property
    def accelerometer_faults(self) -> int:
        """Number of reads of the accelerometer without a sample."""


class LinkReport:
    """Does one part in each of the cycles after a second has begun."""

    def __init__(
        self,
        devices: LinkCounters,
        block: LoopBlock,
        clock: CycleClock,
        counters: ThreadCounters,
        cycle_s: float,
        values_refused: Callable[[], int],
    ) -> None:
        """Start with the first cycle. values_refused: number of values that the controller has refused so far."""
        self._values_refused = values_refused
        self._devices, self._block, self._clock, self._counters = devices, block, clock, counters
        self._cycle_s = cycle_s
        self._every = max(1, round(_EVERY_S / cycle_s))
        self._next = self._cycle = 0
        self._parts: Iterator[None] | None = None

    def advance(self, cycle: int, recorder: RecorderClient) -> None:
        """Do the next part, if one is due. The message has the number of the cycle in which it is complete."""
        self._cycle = cycle
        if self._parts is None:
            if cycle < self._next:
                return
            self._next = cycle + self._every
            self._parts = self._gather(recorder)
        if next(self._parts, _DONE) is _DONE:
            self._parts = None

    def finish(self, recorder: RecorderClient) -> None:
        """Complete the current report at the end of the loop."""
        if self._parts is not None:
            for _ in self._parts:
                pass
            self._parts = None

    def _gather(self, recorder: RecorderClient) -> Iterator[None]:
        devices = self._devices
        self._counters.moved()  # so that an overrun's counters cover the last second at most
        yield
        faults = devices.accelerometer_faults
        self._block.note_accelerometer_faults(faults)
        counts = devices.link_counts
        yield
        status = devices.link_status()
        yield
        alive = recorder.alive()
        yield
        recorder.put(
            _LINK,
            LinkSample(
                time_s=self._cycle * self._cycle_s,
                cycle=self._cycle,
                deadline_misses=self._clock.misses,
                accelerometer_faults=faults,
                values_refused=self._values_refused(),
                recorder_lost=recorder.lost,
                recorder_alive=alive,
                **counts,
                **status,  # type: ignore[arg-type]
            ),
        )


_DONE = object()
