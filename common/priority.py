"""A better place in the ordinary scheduler's queue, where the privileges reach."""

import contextlib
import os


def raise_priority(niceness: int) -> None:
    """Run at a niceness (-20 to 19, lower is sooner), for this process and those it starts; silently not, where
    that is not allowed.
    """
    with contextlib.suppress(OSError, AttributeError):
        os.setpriority(os.PRIO_PROCESS, 0, niceness)
