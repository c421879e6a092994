"""The bare timer beside a whole run: it wakes half a cycle after each of the controller's cycles, from the first on.

Same processor, same priority, and misses by the same rule as the controller's loop.
"""

import os
import sys
import time

from stillarm.benchmarks.loop.counters import block_name
from stillarm.benchmarks.loop.floor_timer import keep_time
from stillarm.common.process.stop_signal import StopSignal
from stillarm.common.user_error import UserError
from stillarm.controller.loop.realtime import RealTime
from stillarm.controller.statistics.loop_block import LoopBlock

_LOOK_S = 0.001
_LOOK_SELDOM_S = 0.05


def main(own_name: str, controller: int, cycle_s: float) -> int:
    """Run from the controller's first cycle to its last, until asked to stop, or until whoever started it is gone."""
    stop, parent = StopSignal(), os.getppid()
    block = LoopBlock(own_name, create=False)
    RealTime().enter()

    def left(cycle: int = 0) -> bool:
        return bool(stop) or (cycle % 1000 == 0 and os.getppid() != parent)

    loop = None
    while loop is None and not left():
        loop = _opened(block_name(controller))
        time.sleep(_LOOK_SELDOM_S)
    while loop is not None and not loop.origin_s and not left():
        time.sleep(_LOOK_S)
    if loop is not None and loop.origin_s:
        counters = loop
        keep_time(block, loop.origin_s + 0.5 * cycle_s, cycle_s, lambda cycle: counters.ended or left(cycle))
    return 0


def _opened(name: str | None) -> LoopBlock | None:
    try:
        return None if name is None else LoopBlock(name, create=False)
    except UserError:  # just being made, or gone already
        return None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3])))
