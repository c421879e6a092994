"""One line of the preflight: the part, its state, and what to do."""

from enum import StrEnum
from typing import NamedTuple


class Level(StrEnum):
    """FAIL: the rig will not work. WARN: it will work less well, or this computer cannot check it."""

    OK = "ok"
    WARN = "warn"
    FAIL = "FAIL"


class Verdict(NamedTuple):
    """where: machine, bus, sensor, camera, link or drive. text: one line, with the remedy if there is one."""

    where: str
    level: Level
    text: str


def ok(where: str, text: str) -> Verdict:
    """A part that is in order."""
    return Verdict(where, Level.OK, text)


def warn(where: str, text: str) -> Verdict:
    """A part that works less well, or could not be checked."""
    return Verdict(where, Level.WARN, text)


def fail(where: str, text: str) -> Verdict:
    """A part that must be corrected first."""
    return Verdict(where, Level.FAIL, text)
