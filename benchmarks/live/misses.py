"""Which missed deadlines are the controller's own, and which the bare timer beside it missed, too."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

_SLACK = 2  # cycles: the timer wakes half a cycle away, and a stall hits one of the two first


class Gap(NamedTuple):
    """Cycles that were missed after `cycle`."""

    cycle: int
    missed: int


def gaps(cycles: Sequence[int]) -> list[Gap]:
    """Where numbers of cycles that were run leave some out."""
    return [Gap(before, after - before - 1) for before, after in pairwise(cycles) if after - before > 1]


def own_misses(loop: Sequence[Gap], floor: Sequence[Gap]) -> int:
    """How many cycles the loop missed at instants at which the bare timer missed none."""
    return sum(gap.missed for gap in loop if not any(_overlap(gap, other) for other in floor))


def _overlap(a: Gap, b: Gap) -> bool:
    return a.cycle <= b.cycle + b.missed + _SLACK and b.cycle <= a.cycle + a.missed + _SLACK
