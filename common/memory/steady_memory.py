"""Keeps a warmed-up process's memory in place: for processes with a deadline once a frame, not once a cycle.

The controller's own loop goes further (controller/loop/realtime.py).
"""

import ctypes
import gc

_MCL_CURRENT, _MCL_ONFAULT = 1, 4  # asm-generic/mman.h


def settle_memory() -> bool:
    """Call it once all is imported and warmed up. Returns whether the pages were locked, as far as privileges reach.

    What the imports made is taken out of the garbage collector's sight: a full collection of it takes some 10 ms. The
    pages in use stay in memory: the kernel may otherwise drop code that runs only when the arm is struck.
    """
    gc.collect()
    gc.freeze()
    locked: bool = ctypes.CDLL(None, use_errno=True).mlockall(_MCL_CURRENT | _MCL_ONFAULT) == 0
    return locked
