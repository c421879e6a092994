"""Gives memory that is freed back to the system: for processes that compute much, have no deadline, and run for long.

glibc raises the size from which an array has pages of its own (mallopt(3), M_MMAP_THRESHOLD) to that of the largest one
that was freed, up to 32 MiB. Arrays of half a megabyte then lie in heaps that cannot shrink. A diagnosis kept a third
more than it used.
"""

import ctypes

_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD, _M_ARENA_MAX = -1, -3, -8  # malloc.h
_OWN_PAGES_BYTES = 1 << 18
_ARENAS = 2  # as many threads compute


def return_freed_memory() -> bool:
    """From now on. Returns whether the C library can; others than glibc cannot, and need not."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is None:
        return False
    settings = (
        (_M_MMAP_THRESHOLD, _OWN_PAGES_BYTES),
        (_M_TRIM_THRESHOLD, _OWN_PAGES_BYTES),
        (_M_ARENA_MAX, _ARENAS),
    )
    return all(mallopt(what, value) == 1 for what, value in settings)
