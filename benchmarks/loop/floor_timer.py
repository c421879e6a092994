"""The bare timer as a separate process next to a running controller: same processor, same priority.

It wakes half a cycle away from the loop, so that they do not disturb each other. Like the loop, it writes its
measurements into a shared block.
"""

import os
import sys
import time
from collections.abc import Callable

from stillarm.common.process.stop_signal import StopSignal
from stillarm.controller.loop.realtime import RealTime
from stillarm.controller.loop.schedule import CycleClock
from stillarm.controller.safety.table import State
from stillarm.controller.statistics.loop_block import LoopBlock

_MISSED = (0.0, 0.0, 0.0, 0.0), (0, 0, 0, 0, 0)


def main(block_name: str, origin_s: float, cycle_s: float) -> int:
    """Run until asked to stop, or until the parent process has ended."""
    stop, block, parent = StopSignal(), LoopBlock(block_name, create=False), os.getppid()
    RealTime().enter()
    keep_time(
        block, origin_s, cycle_s, lambda cycle: bool(stop) or not (cycle % 1000 or os.getppid() == parent)
    )
    return 0


def keep_time(block: LoopBlock, origin_s: float, cycle_s: float, finished: Callable[[int], bool]) -> None:
    """Wake at every cycle and do nothing until `finished` returns True. Misses count as in the controller's loop."""
    clock = CycleClock(cycle_s, origin_s)
    now = time.monotonic
    cycle = clock.start()
    block.begin(origin_s)
    while not finished(cycle):
        late_s = now() - origin_s - cycle * cycle_s
        block.end_cycle(cycle, late_s, 0.0, 0, State.IDLE, None)
        due = clock.wait(cycle)
        if due - cycle > 1:
            block.note_overrun(cycle, due - cycle - 1, *_MISSED)
        cycle = due
    block.end()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], float(sys.argv[2]), float(sys.argv[3])))
