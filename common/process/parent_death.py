"""Ends a process when its parent ends for any reason (Linux: prctl(2), PR_SET_PDEATHSIG)."""

import ctypes
import os
import signal
from collections.abc import Callable

_PR_SET_PDEATHSIG = 1


def ended_with_parent() -> Callable[[], None]:
    """A function for a new process to call before it executes another program: SIGTERM comes when its parent ends."""
    # looked up here: between fork and exec as little as possible is to happen
    prctl = ctypes.CDLL(None).prctl
    parent = os.getpid()

    def ask() -> None:
        prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
        if os.getppid() != parent:  # gone already, before it was asked for
            os._exit(1)

    return ask


def beginning(niceness: int) -> Callable[[], None]:
    """The same, for a child that runs at a lower priority, too. niceness: 0 to 19."""
    ask = ended_with_parent()

    def begin() -> None:
        ask()
        os.nice(niceness)

    return begin
