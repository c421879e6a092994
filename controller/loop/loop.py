"""The loop: read, update, write; then record and count. Once a cycle, on an absolute schedule.

The loop opens, formats and logs nothing, and no memory grows. It writes its reports into shared memory, and other
processes do the rest.
"""

import time
from collections.abc import Callable
from typing import Protocol

from stillarm.common.recorder.recorder_client import RecorderClient
from stillarm.common.recording.topics import TOPIC_INDEX, LogLine, LoopSample
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.link_report import LinkReport
from stillarm.controller.loop.recorded import (
    estimate_sample,
    fast_sample,
    frame_sample,
    settings_sample,
)
from stillarm.controller.loop.schedule import CycleClock
from stillarm.controller.loop.step import Controller, CycleOutput
from stillarm.controller.safety.adjusting import Adjusted
from stillarm.controller.safety.table import GROUND_OF, Event, Operator, State
from stillarm.controller.statistics.loop_block import LoopBlock
from stillarm.controller.statistics.overrun import ThreadCounters

_TOLD_EVERY_S = 1.0  # s: update of the counts for the process that logs
_LONGEST_STOP_S = 0.5  # s: the command has faded out long before


class Devices(Protocol):
    """The devices that the loop reads and writes: stillarm.controller.loop.live_devices.LiveDevices on a rig."""

    def read(self, cycle: int) -> CycleInput:
        """Open a cycle."""

    def write(self, command_rad_s: float) -> None:
        """Send the command."""

    @property
    def link_counts(self) -> dict[str, int]:
        """Counts of the visual datagrams, by name."""

    def link_status(self) -> dict[str, float]:
        """The other fields of /link, by name."""

    @property
    def accelerometer_faults(self) -> int:
        """Number of reads of the accelerometer without a sample."""


class Loop:
    """One run of the controller in real time."""

    def __init__(
        self,
        controller: Controller,
        devices: Devices,
        recorder: RecorderClient | None,
        block: LoopBlock,
        clock: CycleClock,
        cycle_s: float,
    ) -> None:
        """Start nothing; run() does."""
        self._controller = controller
        self._devices = devices
        self._recorder = recorder
        self._block = block
        self._clock = clock
        self._cycle_s = cycle_s
        self._counters = ThreadCounters()
        self._next_told, self._told_every = 0, max(1, round(_TOLD_EVERY_S / cycle_s))
        self._link = LinkReport(
            devices, block, clock, self._counters, cycle_s, lambda: sum(controller.refused)
        )
        self._state: State | None = None
        self._reason: Event | None = None
        self._settings_told = False

    def run(self, finished: Callable[[int], bool]) -> None:
        """Cycle until `finished` returns True, then disarm and continue until the command has faded out."""
        clock, block, cycle_s, now = self._clock, self._block, self._cycle_s, time.monotonic
        devices, step = self._devices, self._controller.step
        origin_s = clock.origin_s
        stopping_from: int | None = None
        longest_stop = round(_LONGEST_STOP_S / cycle_s)
        block.begin(origin_s)
        cycle = clock.start()
        while True:
            woke = now()
            read = devices.read(cycle)
            read_at = now()
            if finished(cycle):
                stopping_from = cycle if stopping_from is None else stopping_from
                read.operator |= _DISARM
            answered = step(read)
            stepped_at = now()
            devices.write(answered.command_rad_s)
            answered_at = now()
            if cycle >= self._next_told:
                self._next_told = cycle + self._told_every
                block.note_accelerometer_faults(devices.accelerometer_faults)
                block.note_refused(self._controller.refused)
            if self._recorder is not None:
                self._record(self._recorder, read, answered)
            late_s = woke - origin_s - cycle * cycle_s
            block.end_cycle(
                cycle, late_s, answered_at - woke, len(read.samples), answered.state, answered.reason
            )
            if stopping_from is not None and (
                answered.command_rad_s == 0.0 or cycle - stopping_from > longest_stop
            ):
                break
            due = clock.wait(cycle)
            if due - cycle > 1:
                device_s = read_at - woke + answered_at - stepped_at
                spent_s = (cycle_s, late_s, device_s, stepped_at - read_at)
                block.note_overrun(cycle, due - cycle - 1, spent_s, self._counters.moved())
            cycle = due
        block.end()
        self._record_end(cycle * cycle_s)
        self._counters.close()

    def _record(self, recorder: RecorderClient, read: CycleInput, answered: CycleOutput) -> None:
        cycle_s, cycle = self._cycle_s, read.cycle
        recorder.put(_FAST, fast_sample(read, answered, cycle_s))
        recorder.put(_ESTIMATE, estimate_sample(cycle, answered, cycle_s))
        for sample in read.samples:
            recorder.put(_FRAMES, frame_sample(sample, cycle, cycle_s))
        if answered.state is not self._state or answered.reason is not self._reason:
            self._state, self._reason = answered.state, answered.reason
            recorder.put(_LOG, LogLine(cycle * cycle_s, *said_of(answered.state, answered.reason)))
        if answered.adjusted is not None or not self._settings_told:
            self._record_settings(recorder, cycle, answered.adjusted)
        self._link.advance(cycle, recorder)

    def _record_settings(self, recorder: RecorderClient, cycle: int, adjusted: Adjusted | None) -> None:
        """At the start, and when an operator has asked for a change: texts are made here for once."""
        self._settings_told = True
        cycle_s = self._cycle_s
        recorder.put(_SETTINGS, settings_sample(cycle, cycle_s, self._controller.settings, adjusted))
        if adjusted is not None:
            recorder.put(_LOG, LogLine(cycle * cycle_s, *adjusted.told))

    def _record_end(self, time_s: float) -> None:
        if self._recorder is not None:
            self._link.finish(self._recorder)
            block = self._block
            lateness, compute = block.lateness.summary(), block.compute.summary()
            self._recorder.put(
                _LOOP, LoopSample(time_s, block.cycles, self._clock.misses, *lateness, *compute)
            )

    def summary(self) -> str:
        """One line about the run."""
        counts = self._devices.link_counts
        return (
            f"stillarm controller: {self._block.cycles} cycles, {self._clock.misses} deadlines missed, "
            f"{counts['accepted']} visual samples, {counts['lost']} lost"
        )


def said_of(state: State, reason: Event | None) -> tuple[str, str]:
    """Level and text of the message for a state, from a fixed set that is made before the loop begins."""
    return _SAID[state, reason]


def _text(state: State, reason: Event | None) -> tuple[str, str]:
    ground = GROUND_OF.get(reason) if reason is not None else None
    if ground is None:
        return "info", str(state) if reason is None else f"{state} ({reason})"
    level = "error" if state is State.FAULT else "warning"
    return level, f"{state}: {ground.message}; {ground.remedy}"


_SAID = {(state, reason): _text(state, reason) for state in State for reason in (None, *Event)}
_DISARM = int(Operator.DISARM)
_FAST, _FRAMES = TOPIC_INDEX["/fast"], TOPIC_INDEX["/frames"]
_ESTIMATE, _LOOP = TOPIC_INDEX["/estimate"], TOPIC_INDEX["/loop"]
_LOG, _SETTINGS = TOPIC_INDEX["/log"], TOPIC_INDEX["/settings"]
