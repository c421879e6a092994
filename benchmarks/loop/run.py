"""`benchmark loop`: the controller under the demo's load, and the bare timer over the same time."""

import os
import secrets
import subprocess
import tempfile
import time
from collections.abc import Callable
from math import sqrt
from pathlib import Path
from typing import Any

from stillarm.benchmarks.loop.counters import block_name
from stillarm.benchmarks.loop.slices import by_name
from stillarm.common.memory.shared_memory import block_path
from stillarm.common.process.child_process import start_module
from stillarm.common.user_error import UserError
from stillarm.controller.statistics.histogram import WORDS, MicrosecondHistogram
from stillarm.controller.statistics.loop_block import LoopBlock
from stillarm.simulation.demo.processes import DemoProcesses
from stillarm.simulation.demo.set_up import write_demo_configuration

_SETTLE_S = 2.0  # after the loop's first cycle, so that the start-up is not measured
_READY_WITHIN_S = 30.0
_MARGIN_S = 4.0


class Window:
    """The counts of a block since the window was opened."""

    def __init__(self, block: LoopBlock) -> None:
        """Open it now."""
        self._block = block
        self._lateness, self._compute = block.lateness.counts(), block.compute.counts()
        self._cycles, self._misses = block.cycles, block.misses
        block.lateness.forget_greatest()
        block.compute.forget_greatest()

    def result(self) -> dict[str, Any]:
        """Wake-up latency, misses and cycles since the window was opened."""
        block = self._block
        return {
            "wakeup_latency_us": _since(block.lateness, self._lateness),
            "deadline_misses": block.misses - self._misses,
            "cycles": block.cycles - self._cycles,
        }

    def compute_us(self) -> dict[str, float]:
        """Time from wake-up to command, since the window was opened."""
        return _since(self._block.compute, self._compute)


def _since(histogram: MicrosecondHistogram, before: list[int]) -> dict[str, float]:
    words = memoryview(bytearray(8 * WORDS)).cast("Q")
    words[0] = histogram.greatest_ns
    for place, (now, was) in enumerate(zip(histogram.counts(), before, strict=True), 1):
        words[place] = now - was
    return by_name(MicrosecondHistogram(words).summary())


def run(
    duration_s: float, seed: int, progress: Callable[[float], None] = lambda done: None
) -> dict[str, Any]:
    """Run rig, supervisor and controller in real time for a while. Raises UserError if one of them fails."""
    with tempfile.TemporaryDirectory(prefix="stillarm-loop-") as folder:
        directory = Path(folder)
        total_s = duration_s + _SETTLE_S + _MARGIN_S
        path, configuration, _ = write_demo_configuration(directory, total_s, seed)
        processes, config = DemoProcesses(directory), ("--config", str(path))
        try:
            processes.start("rig", *config, "--truth", str(directory / "truth.mcap"))
            processes.start("supervisor", *config)
            _wait(block_path(configuration.camera.device).exists, processes)
            recording = ("--record", str(directory / "recording.mcap"))
            processes.start("controller", *config, *recording, "--allow-non-realtime")
            return _measure(duration_s, processes, progress)
        finally:
            processes.stop_all()


def _measure(
    duration_s: float, processes: DemoProcesses, progress: Callable[[float], None]
) -> dict[str, Any]:
    controller = processes.process_id("controller")
    _wait(lambda: block_name(controller) is not None, processes)
    block = LoopBlock(block_name(controller) or "", create=False)
    floor = LoopBlock(f"floor-{os.getpid()}-{secrets.token_hex(4)}", create=True)
    timer = None
    try:
        _wait(lambda: block.cycles > 0, processes)
        timer = _start_timer(floor.name, block.origin_s + 0.5 * _CYCLE_S)
        time.sleep(_SETTLE_S)
        of_loop, of_floor = Window(block), Window(floor)
        begin = time.monotonic()
        while (passed := time.monotonic() - begin) < duration_s:
            processes.check()
            progress(passed / duration_s)
            time.sleep(min(0.5, duration_s - passed))
        result = {"loop": of_loop.result(), "floor": of_floor.result(), "compute_us": of_loop.compute_us()}
        del of_loop, of_floor
        return result
    finally:
        if timer is not None:
            timer.terminate()
            timer.wait(10.0)
        floor.close()
        block.close()


_CYCLE_S = 0.001


def _start_timer(block_name: str, origin_s: float) -> subprocess.Popen[bytes]:
    return start_module("stillarm.benchmarks.loop.floor_timer", block_name, repr(origin_s), repr(_CYCLE_S))


def _wait(condition: Callable[[], bool], processes: DemoProcesses) -> None:
    deadline = time.monotonic() + _READY_WITHIN_S
    while not condition():
        processes.check()
        if time.monotonic() > deadline:
            raise UserError(
                "benchmark loop: rig and controller did not start in time; is the machine overloaded?"
            )
        time.sleep(0.05)


def verdict(result: dict[str, Any]) -> list[dict[str, Any]]:
    """The requirements on the loop relative to the floor (latency, misses, computing time) and the results."""
    loop, floor = result["loop"], result["floor"]
    missed = floor["deadline_misses"]
    asked = (
        (
            "wake-up latency p99, us",
            loop["wakeup_latency_us"]["p99"],
            1.5 * floor["wakeup_latency_us"]["p99"],
        ),
        ("deadline misses", loop["deadline_misses"], 1.5 * missed + 3.0 * sqrt(missed) + 3.0),
        ("compute p99, us", result["compute_us"]["p99"], 300.0),
    )
    return [
        {"asked": name, "found": found, "at most": most, "kept": "yes" if found <= most else "no"}
        for name, found, most in asked
    ]
