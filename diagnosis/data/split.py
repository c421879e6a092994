"""Which part of the time is held out: blocks that lie interleaved in time, on both sides of any onset."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.common.user_error import UserError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# s, of a block; blocks at most, ten of them held out: a gain's standard error is over these
_SHORTEST_S, _BLOCKS = 0.8, 30
_EVERY = 3  # blocks, of which one is held out: two thirds of the time train


@dataclass(frozen=True)
class Split:
    """Which part of the time is held out. edges_s: (blocks + 1,) s; held: (blocks,). lends: a held-out block trains
    where an impact begins a motion that is over before the next block."""

    edges_s: Array
    held: Mask
    lends: bool = False

    @property
    def blocks_per_held(self) -> float:
        """Blocks for each that is held out: what the held-out ones gain, times this, stands for all."""
        return len(self.held) / int(self.held.sum())

    def blocks_of(self, time_s: Array) -> NDArray[np.int64]:
        """Number of the block of each time."""
        return np.clip(np.searchsorted(self.edges_s, time_s, side="right") - 1, 0, len(self.held) - 1)


def interleaved(duration_s: float) -> Split:
    """Every third of at most thirty blocks, none shorter than 0.8 s (of a very short recording: nine blocks)."""
    count = max(9, min(_BLOCKS, int(duration_s / _SHORTEST_S)))
    count -= count % _EVERY
    edges = np.linspace(0.0, duration_s, count + 1)
    return Split(edges, np.arange(count) % _EVERY == 1, lends=True)


def stated(spans_s: Sequence[tuple[float, float]], origin_s: float, duration_s: float) -> Split:
    """Held out as the user says, in the recording's own time. Raises UserError for a span outside of it."""
    edges, held = [0.0], []
    for start, end in sorted(spans_s):
        a, b = start - origin_s, end - origin_s
        if not (a + 1e-9 >= 0.0 and a < b <= duration_s + 1e-9):
            raise UserError(
                f"--hold-out {start:g}:{end:g}: must lie in order within the recording, "
                f"{origin_s:g}:{origin_s + duration_s:g} s"
            )
        if a < edges[-1] - 1e-9:
            raise UserError(f"--hold-out {start:g}:{end:g}: overlaps with the one before it")
        if a > edges[-1]:
            edges.append(a)
            held.append(False)
        # the gain's standard error is over blocks: a long span is several
        pieces = max(1, min(8, int((b - a) / 1.0)))
        for i in range(pieces):
            edges.append(a + (b - a) * (i + 1) / pieces)
            held.append(True)
    if edges[-1] < duration_s - 1e-9:
        edges.append(duration_s)
        held.append(False)
    if all(held):
        raise UserError("--hold-out: leaves nothing to fit; hold out a part of the recording only")
    return Split(np.array(edges), np.array(held))
