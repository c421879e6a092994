"""Power that stays where it is in the spectrum: what rings, hums, howls or hisses in one band for a while.

A short-time spectrum of white noise has independent exponential cells. Here each cell's level is told by the power of
the windows before it at the same frequency, in a few classes; what no simulation has (another axis, gears, bursts of
coloured noise) keeps its place longer than a window, wherever that place is. Each block of the recording is judged by
the levels that the others have, for such things are rare.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_WINDOWS = (32, 64, 128, 256, 512)  # samples
_MEMORIES = (1.0, 3.0, 10.0)  # windows
_FEWEST_WINDOWS = 60
_KNOWN = 0.9  # of a window's samples
_CLASSES = (0.5, 0.8, 0.93, 0.98, 0.995)  # of the cells, by the power before them
_PRIOR_CELLS = 20.0  # of the usual level, in each class


@dataclass(frozen=True)
class _Cells:
    """Power of windows at frequencies over its mean, (windows, frequencies); which windows count; each one's block."""

    power: Array
    counts: Mask
    block: NDArray[np.int64]


def steady_spectrum(values: Array, known: Mask, block: NDArray[np.int64], blocks: int) -> Array:
    """Log-likelihood gained over white noise in each block, by the window and memory that gain most. (blocks,)

    values: residual over its level, (n,); known: which of it counts; block: number of each sample's block.
    """
    best = np.zeros(blocks)
    for length in _WINDOWS:
        cells = _cells(values, known, block, length)
        if cells is None:
            continue
        for memory in _MEMORIES:
            gains = _gains(cells, _before(cells, memory), blocks)
            best = gains if gains.sum() > best.sum() else best
    return best


def _cells(values: Array, known: Mask, block: NDArray[np.int64], length: int) -> _Cells | None:
    """The short-time spectrum; None where too few windows are known. Zero frequency and half the rate are left out:
    their cells have another law."""
    count = len(values) // length
    whole = count * length
    counts = np.asarray(known[:whole].reshape(count, length).mean(axis=1) > _KNOWN)
    if counts.sum() < _FEWEST_WINDOWS:
        return None
    windows = np.where(known, values, 0.0)[:whole].reshape(count, length)
    power = np.abs(np.fft.rfft(windows, axis=1)[:, 1:-1]) ** 2
    mean = max(float(power[counts].mean()), 1e-300)
    return _Cells(power / mean, counts, block[length // 2 : whole : length])


def _before(cells: _Cells, memory: float) -> Array:
    """Mean power near each cell's frequency in the windows before it, fading within `memory` windows to the usual."""
    near = cells.power.copy()
    near[:, 1:-1] = 0.25 * (cells.power[:, :-2] + 2.0 * cells.power[:, 1:-1] + cells.power[:, 2:])
    stay = float(np.exp(-1.0 / memory))
    found, now = np.ones_like(near), np.zeros(near.shape[1])
    for i in range(1, len(near)):
        now = stay * now
        if cells.counts[i - 1]:
            now = now + (1.0 - stay) * (near[i - 1] - 1.0)
        found[i] += now
    return found


def _gains(cells: _Cells, before: Array, blocks: int) -> Array:
    """Gain of each block's cells over a level of one, by the levels that their classes have in the other blocks."""
    power, known = cells.power[cells.counts], before[cells.counts]
    edges = np.unique(np.quantile(known, _CLASSES))
    classes = len(edges) + 1
    place = (cells.block[cells.counts][:, None] * classes + np.searchsorted(edges, known)).ravel()
    size = blocks * classes
    sums = np.bincount(place, power.ravel(), size).reshape(blocks, classes)
    counts = np.bincount(place, minlength=size).reshape(blocks, classes)
    level = (sums.sum(axis=0) - sums + _PRIOR_CELLS) / (counts.sum(axis=0) - counts + _PRIOR_CELLS)
    gains: Array = np.sum(sums * (1.0 - 1.0 / level) - counts * np.log(level), axis=1)
    return gains
