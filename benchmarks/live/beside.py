"""What runs beside a demo: the bare timer, and as many busy processes as are asked for."""

import os
import secrets
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field

from stillarm.benchmarks.live.misses import Gap
from stillarm.common.process.child_process import start_module, stop_process
from stillarm.common.process.parent_death import ended_with_parent
from stillarm.controller.statistics.loop_block import LoopBlock

_STOP_WITHIN_S = 5.0


@dataclass
class Floor:
    """What the bare timer counted: cycles that it woke for, those that it missed, and where (the last 64 times)."""

    cycles: int = 0
    deadline_misses: int = 0
    gaps: list[Gap] = field(default_factory=list)


@contextmanager
def company(controller: int, cycle_s: float, load: int, floor: Floor) -> Iterator[None]:
    """Run `load` busy processes and the bare timer of the controller with that process number; fills in `floor`."""
    block = LoopBlock(f"floor-{os.getpid()}-{secrets.token_hex(4)}", create=True)
    with ExitStack() as stack:
        stack.callback(block.close)
        words: list[tuple[str, ...]] = [
            ("stillarm.benchmarks.live.floor", block.name, str(controller), repr(cycle_s))
        ]
        words += [("stillarm.benchmarks.live.busy",)] * load
        for module, *arguments in words:
            process = start_module(
                module,
                *arguments,
                stdin=subprocess.DEVNULL,
                # Of a session of its own, as another program's: Ctrl-C does not reach it, and the kernel's scheduler
                # gives it a share beside the demo's, not within it.
                start_new_session=True,
                preexec_fn=ended_with_parent(),  # no thread runs yet, and it calls the kernel only
            )
            stack.callback(stop_process, process, _STOP_WITHIN_S)
        try:
            yield
        finally:
            floor.cycles, floor.deadline_misses = block.cycles, block.misses
            floor.gaps = [Gap(overrun.cycle, overrun.missed) for overrun in block.overruns(0)[1]]
