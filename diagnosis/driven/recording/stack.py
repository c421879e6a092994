"""How samples of all sensors are stacked for a fit: by blocks, and in a block by sensors, so that a block is one slice.

What was not measured is left at zero.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.recording.signals import Output

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stack:
    """How a recording's samples are stacked. starts: first sample of each block, and the end."""

    outputs: tuple[Output, ...]
    starts: NDArray[np.int64]

    @cached_property
    def bounds(self) -> list[tuple[int, int]]:
        """Where each block begins and ends."""
        edges = (len(self.outputs) * self.starts).tolist()
        return list(pairwise(edges))

    @cached_property
    def places(self) -> NDArray[np.int64]:
        """Where an output's samples of a block begin, (outputs, blocks)."""
        starts, outputs = self.starts, len(self.outputs)
        return outputs * starts[:-1] + np.arange(outputs)[:, None] * np.diff(starts)

    def of(self, by_output: list[Array]) -> Array:
        """Each output's samples, (n,), stacked."""
        stacked = np.empty(len(by_output) * int(self.starts[-1]))
        starts = self.starts
        for values, places in zip(by_output, self.places, strict=True):
            for place, begins, ends in zip(places, starts[:-1], starts[1:], strict=True):
                stacked[place : place + ends - begins] = values[begins:ends]
        return stacked

    @cached_property
    def measured(self) -> Array:
        """What was measured, zero where nothing was."""
        return self.of([np.nan_to_num(one.values) for one in self.outputs])

    @cached_property
    def known(self) -> NDArray[np.bool_] | None:
        """Where something was measured; None where that is everywhere."""
        there = self.of([np.isfinite(one.values).astype(np.float64) for one in self.outputs]) > 0.0
        return None if there.all() else there

    @cached_property
    def output(self) -> NDArray[np.int64]:
        """Number of each sample's output."""
        outputs = range(len(self.outputs))
        return self.of([np.full(int(self.starts[-1]), float(k)) for k in outputs]).astype(np.int64)

    def deviations(self, sigma: dict[str, float]) -> Array:
        """One over each sample's deviation."""
        return np.array([1.0 / sigma[one.name] for one in self.outputs])[self.output]

    def squares(self, errors: Array) -> Array:
        """Sums of squares, (blocks, outputs)."""
        lengths = np.diff(self.starts)
        first = np.minimum(self.places.T.ravel(), max(len(errors) - 1, 0))
        sums = np.add.reduceat(errors * errors, first).reshape(len(lengths), -1)
        return np.where(lengths[:, None] > 0, sums, 0.0)

    @cached_property
    def counts(self) -> Array:
        """How many samples were measured, (blocks, outputs)."""
        known = self.of([np.isfinite(one.values).astype(np.float64) for one in self.outputs])
        return self.squares(known)

    @cached_property
    def usual(self) -> list[float]:
        """Each output's deviation."""
        return [float(np.nanstd(one.values)) for one in self.outputs]


__all__ = ["Stack"]
