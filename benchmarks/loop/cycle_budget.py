"""Where a cycle's time goes: duration, calls and allocations of each section, in three passes of the loop itself.

The loop, the step, the devices and the recorder are those of the controller; loopback_rig.py answers them. Calls and
allocations are counted in passes of their own, since counting takes longer than what is counted.
"""

import secrets
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from stillarm.benchmarks.loop import sections
from stillarm.benchmarks.loop.allocations import AllocationCounter, countable
from stillarm.benchmarks.loop.loopback_rig import LoopbackRig, loopback_configuration
from stillarm.benchmarks.loop.sections import (
    MarkedClock,
    MarkedDevices,
    MarkedMethod,
    Section,
    SectionMeter,
)
from stillarm.benchmarks.loop.unavoidable import floor_ns
from stillarm.common.files.configuration import default_configuration_path
from stillarm.common.process.loop_processor import beside_the_loop
from stillarm.common.recorder.recorder_client import RecorderClient
from stillarm.common.recording.header import live_header
from stillarm.controller.loop.live_devices import LiveDevices
from stillarm.controller.loop.loop import Loop
from stillarm.controller.loop.step import Controller
from stillarm.controller.statistics.loop_block import LoopBlock

_COUNTED_CYCLES = 600
_COUNTED_CYCLE_S = 4.0  # of the loop's cycle: time enough for the counting, which must make it miss none
_LEFT_OUT = 200  # cycles at the start of each pass: the method has begun, and caches are warm
_LEAD_S = 0.01


@dataclass
class SectionFigures:
    """Of one section in a cycle: duration, us, median and 99th percentile; the same of the floor, None where there is
    none; mean number of calls, and of allocations, None where they cannot be counted.
    """

    us: tuple[float, float]
    floor_us: tuple[float, float] | None
    calls: float
    allocations: float | None


class CycleBudget:
    """Made before the real-time measures, so that its recorder keeps off the loop's processor."""

    def __init__(self) -> None:
        """Open the devices and start a recorder that writes no file. Raises UserError."""
        self._configuration, self._model = loopback_configuration()
        self._rig = LoopbackRig(self._configuration, self._model)
        self._devices = LiveDevices(self._configuration, self._model)
        self._rig.start(self._devices)
        header = live_header(default_configuration_path(), self._configuration, self._devices.session, 0.0)
        with beside_the_loop():
            self._recorder = RecorderClient.launch(stderr=subprocess.DEVNULL)
            self._recorder.begin(None, header)
        self._cycle = 0
        self._late_ns: list[int] = []  # of the last pass

    def measure(self, duration_s: float) -> dict[Section, SectionFigures]:
        """Run the passes. duration_s: of the timed one, which is in real time."""
        cycle_s = self._model.timing.cycle_s
        cycles = max(_LEFT_OUT + 100, round(duration_s / cycle_s))
        took_ns = self._passed(time.perf_counter_ns, cycles, cycle_s)
        took_ns[:, Section.SLEEP] = self._late_ns
        slow_s = _COUNTED_CYCLE_S * cycle_s
        calls = self._counted_calls(slow_s)
        allocations = self._counted_allocations(slow_s) if countable() else None
        floor = floor_ns(self._configuration, cycles, cycle_s)
        return {
            section: SectionFigures(
                _percentiles_us(took_ns[:, section]),
                _percentiles_us(np.array(floor[section])) if section in floor else None,
                float(calls[:, section].mean()),
                None if allocations is None else float(allocations[:, section].mean()),
            )
            for section in Section
        }

    def _passed(self, reading: Callable[[], int], cycles: int, clock_cycle_s: float) -> Any:
        """Rises of the reading in a pass of the loop, (cycles, sections). clock_cycle_s: between two wake-ups."""
        meter = SectionMeter(reading)
        controller = Controller(self._model, self._configuration.controller)
        controller.method = MarkedMethod(controller.method, meter)
        clock = MarkedClock(
            clock_cycle_s, time.monotonic() + _LEAD_S - self._cycle * clock_cycle_s, meter, self._rig
        )
        block = LoopBlock(f"latency-{secrets.token_hex(4)}", create=True)
        devices = MarkedDevices(self._devices, meter)
        loop = Loop(controller, devices, self._recorder, block, clock, self._model.timing.cycle_s)
        self._rig.advance(self._cycle)
        try:
            # by the cycles that ran: a busy machine leaves some out
            loop.run(lambda cycle: len(meter.rows) >= cycles)
        finally:
            self._cycle = block.cycle + 1
            block.close()
        self._late_ns = clock.late_ns[_LEFT_OUT:]
        return np.array(meter.rows[_LEFT_OUT:])

    def _counted_calls(self, clock_cycle_s: float) -> Any:
        count = [0]
        own = Path(sections.__file__).name  # the marks' own calls belong to no section

        def see(frame: FrameType, event: str, argument: object) -> None:
            if event in {"call", "c_call"} and not frame.f_code.co_filename.endswith(own):
                count[0] += 1

        sys.setprofile(see)
        try:
            return self._passed(lambda: count[0], _COUNTED_CYCLES, clock_cycle_s)
        finally:
            sys.setprofile(None)

    def _counted_allocations(self, clock_cycle_s: float) -> Any:
        counter = AllocationCounter()
        with counter.counting():
            return self._passed(counter.count, _COUNTED_CYCLES, clock_cycle_s)

    def close(self) -> None:
        """Release everything; may be called once."""
        self._devices.close()
        self._rig.close()
        self._recorder.close()


def _percentiles_us(durations_ns: Any) -> tuple[float, float]:
    p50, p99 = np.percentile(durations_ns, (50.0, 99.0)) * 1e-3
    return float(p50), float(p99)
