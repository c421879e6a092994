"""A process's place in the scheduler's queue, as far as its privileges reach."""

import contextlib
import os
from pathlib import Path


def raise_priority(niceness: int) -> None:
    """Set the niceness (-20 to 19, lower runs sooner) of this process and its children; ignored if not allowed."""
    with contextlib.suppress(OSError, AttributeError):
        os.setpriority(os.PRIO_PROCESS, 0, niceness)


def raise_session_priority(niceness: int) -> None:
    """Have this process's session run at a niceness beside other sessions; silently not, where that is not allowed.

    Where the kernel groups processes by session (sched(7), "The autogroup feature"), a niceness ranks a process within
    its session only, and sessions share the processor alike.
    """
    raise_priority(niceness)
    with contextlib.suppress(OSError):
        Path("/proc/self/autogroup").write_text(str(niceness))


def run_fifo(priority: int) -> bool:
    """Run this thread before all ordinary ones, under SCHED_FIFO (1 to 99); those it starts are ordinary again.

    Returns whether that was allowed.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
    except (OSError, AttributeError):
        return False
    return True
