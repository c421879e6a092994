"""How much memory a diagnosis takes: few worlds remember what their simulations have in common, and what is freed goes
back to the system."""

import ctypes
from contextlib import suppress
from typing import Protocol
from weakref import ref

_REMEMBER = 4
"""Worlds that remember at once: those of a comparison's forms take turns, and each holds 40 MB of a minute."""


class Forgetting(Protocol):
    """What remembers results, and may give their memory back."""

    def forget(self) -> None:
        """Give the memory of what is remembered back."""


_recent: list["ref[Forgetting]"] = []


def remembers(one: Forgetting) -> None:
    """Note that one remembers something now. Of more than a few, the one that was noted longest ago forgets. Threads
    may share this: at worst one of them keeps its memory, or does the same twice."""
    recent = list(_recent)
    if recent and recent[-1]() is one:
        return
    others = [each for each in recent if each() is not None and each() is not one]
    for each in others[: 1 - _REMEMBER]:
        oldest = each()
        if oldest is not None:
            oldest.forget()
    _recent[:] = [*others[1 - _REMEMBER :], ref(one)]


def give_back() -> None:
    """Give what was freed back to the system: glibc's malloc keeps it otherwise, in pieces between what is in use
    (malloc_trim(3)). Nothing happens with another C library."""
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).malloc_trim(0)
