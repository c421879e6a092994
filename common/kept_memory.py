"""Memory that was freed is kept by the process: given back and taken again, each of its pages costs a fault."""

import ctypes

_M_TRIM_THRESHOLD, _M_MMAP_MAX = -1, -4  # malloc.h


def keep_freed_memory() -> None:
    """From now on keep what is freed, and take large blocks from there too; nothing where the C library has no such
    choice."""
    libc = ctypes.CDLL(None)
    if hasattr(libc, "mallopt"):
        libc.mallopt(_M_TRIM_THRESHOLD, ctypes.c_int(2**31 - 1))
        libc.mallopt(_M_MMAP_MAX, 0)
