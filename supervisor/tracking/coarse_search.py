"""Locates the scene to a few px after prediction has failed: normalised correlation of small images at every shift.

Method: Padfield, Masked object registration in the Fourier domain, IEEE TIP 2012. Means and variances are those of
the part that both images see at each shift, so that the search also finds large shifts with a small common part.
(Phase correlation lost the scene at a quarter of the image.) A small common part correlates by chance more easily.
The score is therefore the correlation times the square root of the common share. The best shift is only a start:
Lucas-Kanade has to confirm it.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stillarm.supervisor.tracking.matching.photometry import overlapping
from stillarm.supervisor.tracking.matching.prepared_image import SmallImage, inner_product

MIN_COMMON = 0.12  # share of the image
_ENOUGH = 4000  # px: above this, every second one of a row and a column is enough


class CoarseShift(NamedTuple):
    """x, y: motion of the scene in px of the small image; score: correlation * sqrt(share in common), -1..1."""

    x: int
    y: int
    score: float


@dataclass(frozen=True, slots=True)
class CoarseView:
    """A small image with the data that the search needs: computed once an image, not once a pair.

    spectrum: of the image minus its mean, padded to twice its size
    sums, variations: of the values, and of their squares about the mean, over the part that remains in view after
        each shift (negative shifts in the upper half, as in a Fourier transform), shape (2 height, 2 width), float32
    energy: the sum of all squares
    """

    shape: tuple[int, int]
    spectrum: NDArray[np.complex64]
    sums: SmallImage
    variations: SmallImage
    energy: float


def coarse_view(image: SmallImage) -> CoarseView:
    """The data of an image that coarse_shift() needs."""
    values = image.astype(np.float64) - float(image.mean())
    height, width = image.shape
    sums, squares = _sums_seen(values), _sums_seen(values * values)
    return CoarseView(
        (height, width),
        np.asarray(np.fft.rfft2(values.astype(np.float32), (2 * height, 2 * width)), dtype=np.complex64),
        sums,
        squares - sums * sums / _area_seen(height, width),
        float(squares[0, 0]),
    )


def coarse_shift(before: CoarseView, image: CoarseView) -> CoarseShift:
    """How far the scene of `before` has moved in `image`. Both have the same shape."""
    height, width = image.shape
    area = _area_seen(height, width)
    common = area * np.float32(1.0 / (height * width))
    variation = _reversed(before.variations) * image.variations
    smallest = np.float32(1e-6 * (before.energy * image.energy + 1e-9))  # below it, rounding errors dominate
    score = np.fft.irfft2(before.spectrum.conj() * image.spectrum, area.shape)
    score -= _reversed(before.sums) * image.sums / area
    score *= np.sqrt(common / np.maximum(variation, smallest))
    score[(common < MIN_COMMON) | (variation <= smallest)] = -1.0
    y, x = divmod(int(np.argmax(score)), 2 * width)
    return CoarseShift(x - 2 * width * (x >= width), y - 2 * height * (y >= height), float(score[y, x]))


@lru_cache(maxsize=4)
def _area_seen(height: int, width: int) -> SmallImage:
    """How many px both images see after each shift, at least 1."""
    y, x = (np.maximum(np.abs(np.arange(2 * n) - n), 1).astype(np.float32) for n in (height, width))
    return y[:, None] * x[None, :]


def _sums_seen(values: NDArray[np.float64]) -> SmallImage:
    """Sums over the part of an image that a scene shifted by (x, y) still covers: from x on, or up to width + x."""
    height, width = values.shape
    total = np.zeros((height + 1, width + 1))
    np.cumsum(np.cumsum(values, axis=0), axis=1, out=total[1:, 1:])
    small = total.astype(np.float32)
    seen = np.empty((2 * height, 2 * width), np.float32)
    seen[:height, width:] = small[-1, :-1] - small[:-1, :-1]
    seen[height:, width:] = small[:-1, :-1]
    seen[:height, :width] = (small[-1, -1] - small[:-1, -1:]) - seen[:height, width:]
    seen[height:, :width] = small[:-1, -1:] - small[:-1, :-1]
    return seen


def _reversed(sums: SmallImage) -> SmallImage:
    """The same for the opposite shifts."""
    return np.roll(sums[::-1, ::-1], (1, 1), axis=(0, 1))


def overlap_score(before: SmallImage, image: SmallImage, shift_x: int, shift_y: int) -> float:
    """The score of coarse_shift() at one shift; -1 if the common part is too small."""
    a, b = overlapping(before, image, shift_x, shift_y)
    if a.size < MIN_COMMON * image.size:
        return -1.0
    share = a.size / image.size
    if a.size > _ENOUGH:
        a, b = a[::2, ::2], b[::2, ::2]
    a, b = a - a.mean(), b - b.mean()
    norm = sqrt(inner_product(a, a) * inner_product(b, b))
    return inner_product(a, b) / norm * sqrt(share) if norm > 0.0 else -1.0
