"""One line of the preflight: what was looked at, how it is, and what to do."""

from enum import StrEnum
from typing import NamedTuple


class Level(StrEnum):
    """FAIL: the rig will not work so. WARN: it will, but not as well, or this computer cannot tell."""

    OK = "ok"
    WARN = "warn"
    FAIL = "FAIL"


class Verdict(NamedTuple):
    """where: machine, bus, sensor, camera, link or drive. text: one line, with the remedy where there is one to say."""

    where: str
    level: Level
    text: str


def ok(where: str, text: str) -> Verdict:
    """Good as it is."""
    return Verdict(where, Level.OK, text)


def warn(where: str, text: str) -> Verdict:
    """Worth knowing."""
    return Verdict(where, Level.WARN, text)


def fail(where: str, text: str) -> Verdict:
    """To be mended first."""
    return Verdict(where, Level.FAIL, text)
