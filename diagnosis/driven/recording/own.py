"""Numbers that one of several recordings has for itself, by their names: "coulomb @1" is "coulomb" in recording 1.

A name without a mark holds in every recording that has no number of its own. So what is common to a rig is fitted once,
and what differs apart, without a second kind of number.
"""

from collections.abc import Mapping

_MARK = " @"


def named_in(name: str, recording: int) -> str:
    """The number's name where it is that recording's own."""
    return f"{name}{_MARK}{recording}"


def base_of(name: str) -> str:
    """The number's name without a recording's mark."""
    return name.partition(_MARK)[0]


def recording_of(name: str) -> int | None:
    """Which recording a number is the own of; None where it is common."""
    _, mark, recording = name.partition(_MARK)
    return int(recording) if mark else None


def numbers_in(numbers: Mapping[str, float], recording: int) -> dict[str, float]:
    """All numbers as they hold in a recording, by their plain names."""
    common = {name: value for name, value in numbers.items() if _MARK not in name}
    own = {base_of(name): value for name, value in numbers.items() if recording_of(name) == recording}
    return {**common, **own}


def with_own(numbers: Mapping[str, float], free: tuple[str, ...]) -> dict[str, float]:
    """The numbers with a value for every free one: a recording's own begins at the common one."""
    begun = {
        name: numbers[base_of(name)] for name in free if name not in numbers and base_of(name) in numbers
    }
    return {**begun, **numbers}
