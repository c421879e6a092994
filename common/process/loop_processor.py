"""The processor that the controller's loop takes, and the others.

A process that runs on the loop's processor between two cycles leaves it cold caches: the same step then takes half as
long again. If there are several processors, all other processes of the program on this computer use the others.
"""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path


def loop_processor() -> int:
    """The last of those that this process may use. Raises AttributeError where the system has no such choice."""
    return max(os.sched_getaffinity(0))


def leave_it_to_the_loop() -> None:
    """Keep this process, and what it starts from now on, off the loop's processor; not where there is no other."""
    with contextlib.suppress(OSError, AttributeError):
        others = os.sched_getaffinity(0) - {loop_processor()}
        if others:
            os.sched_setaffinity(0, others)


def send_beside_the_loop(process: int) -> None:
    """Keep a running child off the loop's processor, with all its threads; not where there is no other, or no child."""
    with contextlib.suppress(OSError, AttributeError):
        others = os.sched_getaffinity(0) - {loop_processor()}
        for thread in Path(f"/proc/{process}/task").iterdir() if others else ():
            os.sched_setaffinity(int(thread.name), others)


@contextlib.contextmanager
def beside_the_loop() -> Iterator[None]:
    """Processes started in this block keep off the loop's processor; the calling thread itself only for so long."""
    try:
        before = os.sched_getaffinity(0)
    except (OSError, AttributeError):
        yield
        return
    leave_it_to_the_loop()
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)
