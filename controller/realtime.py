"""What makes an ordinary Linux process keep a 1 ms cycle, as far as its privileges reach."""

import ctypes
import gc
import os

from common.priority import run_fifo

_MCL_CURRENT, _MCL_FUTURE = 1, 2
_PRIORITY = 60


def enter_realtime() -> list[str]:
    """Lock memory, freeze the collector, run under SCHED_FIFO on the last processor.

    Returns what could not be done, each with how to grant it; an empty list when all of it holds.
    """
    problems = []
    gc.collect()
    gc.freeze()
    gc.disable()
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.mlockall(_MCL_CURRENT | _MCL_FUTURE) != 0:
        problems.append("memory is not locked (grant CAP_IPC_LOCK, or LimitMEMLOCK=infinity)")
    if not run_fifo(_PRIORITY):
        problems.append("no SCHED_FIFO (grant CAP_SYS_NICE, or LimitRTPRIO=99)")
    try:
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    except (OSError, AttributeError):
        problems.append("not pinned to a processor")
    return problems
