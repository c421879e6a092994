"""Which blocks are held out where the input may be periodic: one of every three, at a place that changes.

Laboratories drive their rigs by square waves and periodic multisines. If every third block were held out, a period of
three blocks would put all of its jumps into the blocks that no fit sees. The first block is never held out: the start
from rest, where the arm rings most, is like nothing that comes later.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.split import Split, interleaved

_MOST_BLOCKS, _SHORTEST_S = (
    15,
    0.8,
)  # each has a state of its own, which takes away what is slower than the block
_LONGEST_PERIOD, _SHIFTS = 7, 50  # blocks; where few blocks are, not every beginning avoids every period
# a third, each between two that train: where a joint has drifted to at the end is like nothing before. Their jumps may
# well be all held out: what is slow has none.
_LONG_HELD = (False, True, False, False, True, False)
_GOLDEN = 0.6180339887498949  # multiples of it are the least periodic


def irregular(duration_s: float) -> Split:
    """Blocks as `interleaved` has them; of each three, one that no period foretells is held out."""
    split = interleaved(min(duration_s, _MOST_BLOCKS * _SHORTEST_S))
    split = replace(split, edges_s=np.linspace(0.0, duration_s, len(split.edges_s)))
    tried = [_held(len(split.held), shift) for shift in range(_SHIFTS)]
    seen = [one for one in tried if not one[0]]
    return replace(split, held=next((one for one in seen if not _has_a_period(one)), seen[0]))


def longer(split: Split) -> Split | None:
    """A few long blocks in place of those of `irregular`, for what is slower than these; None of any other split: what
    somebody holds out stays so."""
    duration_s = float(split.edges_s[-1])
    own = irregular(duration_s)
    if len(own.held) != len(split.held) or not (own.held == split.held).all():
        return None
    return Split(np.linspace(0.0, duration_s, len(_LONG_HELD) + 1), np.array(_LONG_HELD), split.lends)


def _held(blocks: int, shift: int) -> NDArray[np.bool_]:
    """One of each three; shift: where in the multiples of the golden section it begins."""
    groups = blocks // 3
    place = np.floor(3.0 * ((np.arange(1, groups + 1) + shift) * _GOLDEN % 1.0)).astype(np.int64)
    held = np.zeros(blocks, bool)
    held[3 * np.arange(groups) + place] = True
    return held


def _has_a_period(held: NDArray[np.bool_]) -> bool:
    """Whether all blocks of one phase of a short period are held out."""
    return any(
        held[phase::period].all() for period in range(2, _LONGEST_PERIOD + 1) for phase in range(period)
    )
