"""The loop's report in shared memory: counters, histograms, the last overruns and changes of state.

One process writes, others read; each word is stored atomically. A reader of the rings may find an entry that is being
written. That is acceptable in a report for people; the next reading is right.
"""

from typing import NamedTuple

from stillarm.common.memory.shared_memory import SharedBlock
from stillarm.controller.input.plausible_input import Field
from stillarm.controller.safety.table import Event, State
from stillarm.controller.statistics.histogram import WORDS, MicrosecondHistogram
from stillarm.controller.statistics.overrun import OverrunCounters

_RING = 64
_OVERRUN_WORDS, _CHANGE_WORDS = 12, 3
_CYCLE, _CYCLES, _MISSES, _OVERRUNS, _CHANGES, _SAMPLES, _FAULTS, _ENDED, _ORIGIN = range(9)
_OVERRUN_AT = 16
_CHANGE_AT = _OVERRUN_AT + _RING * _OVERRUN_WORDS
_LATENESS_AT = _CHANGE_AT + _RING * _CHANGE_WORDS
_COMPUTE_AT = _LATENESS_AT + WORDS
_REFUSED_AT = _COMPUTE_AT + WORDS
_SIZE = 8 * (_REFUSED_AT + len(Field))
_STATES, _EVENTS = tuple(State), tuple(Event)
_STATE_NUMBER = {state: number for number, state in enumerate(_STATES)}
_EVENT_NUMBER: dict[Event | None, int] = {event: 1 + number for number, event in enumerate(_EVENTS)} | {
    None: 0
}
_NS = 1e9


class Overrun(NamedTuple):
    """Cycles that were missed after `cycle`."""

    cycle: int
    missed: int
    counters: OverrunCounters


class Change(NamedTuple):
    """A change of state."""

    cycle: int
    state: State
    reason: Event | None


class LoopBlock:
    """The block, for the writer and for readers."""

    def __init__(self, name: str, *, create: bool) -> None:
        """Make or open the block `name`. Raises UserError on failure."""
        self.name = name
        self._block = SharedBlock(name, _SIZE, create=create)
        self.words = self._block.buffer.cast("Q")
        self.lateness = MicrosecondHistogram(self.words[_LATENESS_AT:_COMPUTE_AT])
        self.compute = MicrosecondHistogram(self.words[_COMPUTE_AT : _COMPUTE_AT + WORDS])
        self._state: State | None = None
        self._reason: Event | None = None

    def end_cycle(
        self, cycle: int, late_s: float, compute_s: float, samples: int, state: State, reason: Event | None
    ) -> None:
        """Count one cycle."""
        words = self.words
        words[_CYCLE] = cycle
        words[_CYCLES] += 1
        if samples:
            words[_SAMPLES] += samples
        self.lateness.add(late_s)
        self.compute.add(compute_s)
        if state is not self._state or reason is not self._reason:
            self._note_change(cycle, state, reason)

    def _note_change(self, cycle: int, state: State, reason: Event | None) -> None:
        self._state, self._reason = state, reason
        words = self.words
        at = _CHANGE_AT + words[_CHANGES] % _RING * _CHANGE_WORDS
        words[at], words[at + 1], words[at + 2] = cycle, _STATE_NUMBER[state], _EVENT_NUMBER[reason]
        words[_CHANGES] += 1

    def note_overrun(
        self,
        cycle: int,
        missed: int,
        spent_s: tuple[float, float, float, float],
        moved: tuple[int, int, int, int, int],
    ) -> None:
        """Store an overrun. spent_s: cycle_s, late_s, device_s, computing_s; moved: ThreadCounters.moved()."""
        words = self.words
        at = _OVERRUN_AT + words[_OVERRUNS] % _RING * _OVERRUN_WORDS
        words[at], words[at + 1] = cycle, missed
        for place, seconds in enumerate(spent_s, at + 2):
            words[place] = max(0, int(seconds * _NS))
        for place, count in enumerate(moved, at + 6):
            words[place] = max(0, count)
        words[_MISSES] += missed
        words[_OVERRUNS] += 1

    def note_accelerometer_faults(self, faults: int) -> None:
        """Store the number of reads without a sample."""
        self.words[_FAULTS] = faults

    def note_refused(self, counts: list[int]) -> None:
        """Store the number of input values refused since the start, by Field."""
        for place, count in enumerate(counts, _REFUSED_AT):
            self.words[place] = count

    def begin(self, origin_s: float) -> None:
        """Set the time of cycle 0, on the monotonic clock."""
        self.words[_ORIGIN] = int(origin_s * _NS)

    def end(self) -> None:
        """Set that the loop has ended in order."""
        self.words[_ENDED] = 1

    @property
    def origin_s(self) -> float:
        """Time of cycle 0 on the monotonic clock; 0 before the loop begins."""
        return int(self.words[_ORIGIN]) / _NS

    @property
    def cycle(self) -> int:
        """Number of the last cycle."""
        return int(self.words[_CYCLE])

    @property
    def cycles(self) -> int:
        """Number of cycles run. It moves as long as the loop runs."""
        return int(self.words[_CYCLES])

    @property
    def misses(self) -> int:
        """Number of missed cycles."""
        return int(self.words[_MISSES])

    @property
    def samples(self) -> int:
        """Number of visual samples received."""
        return int(self.words[_SAMPLES])

    @property
    def accelerometer_faults(self) -> int:
        """Number of reads of the accelerometer without a sample."""
        return int(self.words[_FAULTS])

    @property
    def refused(self) -> list[int]:
        """Number of input values refused since the start, by Field."""
        counts: list[int] = self.words[_REFUSED_AT : _REFUSED_AT + len(Field)].tolist()
        return counts

    @property
    def ended(self) -> bool:
        """Whether the loop has ended in order."""
        return bool(self.words[_ENDED])

    def overruns(self, since: int) -> tuple[int, list[Overrun]]:
        """Number of overruns so far, and those after the first `since` that are still stored."""
        words, count = self.words, int(self.words[_OVERRUNS])
        found = []
        for number in range(max(since, count - _RING), count):
            at = _OVERRUN_AT + number % _RING * _OVERRUN_WORDS
            row = words[at : at + _OVERRUN_WORDS].tolist()
            (
                cycle,
                missed,
                length,
                late,
                device,
                computing,
                minor,
                major,
                voluntary,
                involuntary,
                waited,
                _,
            ) = row
            counters = OverrunCounters(
                length / _NS, late / _NS, device / _NS, computing / _NS,
                minor, major, voluntary, involuntary, waited / _NS,
            )  # fmt: skip
            found.append(Overrun(cycle, missed, counters))
        return count, found

    def changes(self, since: int) -> tuple[int, list[Change]]:
        """Number of changes of state so far, and those after the first `since` that are still stored."""
        words, count = self.words, int(self.words[_CHANGES])
        found = []
        for number in range(max(since, count - _RING), count):
            at = _CHANGE_AT + number % _RING * _CHANGE_WORDS
            cycle, state, reason = words[at : at + _CHANGE_WORDS].tolist()
            found.append(Change(cycle, _STATES[state], _EVENTS[reason - 1] if reason else None))
        return count, found

    def remove(self) -> None:
        """Remove the name, since the process that made the block is gone."""
        self._block.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Release the memory, and the name if this side made it; may be called twice."""
        self.lateness, self.compute = MicrosecondHistogram(), MicrosecondHistogram()
        self.words.release()
        self._block.close()
