"""Where the scene is, to a few px, when prediction has failed: phase correlation of small images.

Kuglin and Hines 1975. The shift it gives is known up to the image's size; each of the possible ones is
judged by the normalised
correlation of what both images then see, and the best is only a start: Lucas-Kanade has to confirm it.
"""

from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np

from supervisor.tracking.photometry import overlapping
from supervisor.tracking.prepared_image import SmallImage

_MIN_OVERLAP = (
    0.12  # of the image: with less, the correlation of two unlike scenes is high by chance too often
)


class CoarseShift(NamedTuple):
    """x, y: motion of the scene in px of the small image; correlation: of the overlap, -1..1."""

    x: float
    y: float
    correlation: float


@lru_cache(maxsize=8)
def _window(height: int, width: int) -> SmallImage:
    return np.asarray(cv2.createHanningWindow((width, height), cv2.CV_32F))


def coarse_shift(before: SmallImage, image: SmallImage) -> CoarseShift:
    """By how much the scene of `before` has moved in `image`; both float32 of one shape."""
    height, width = image.shape
    (x, y), _ = cv2.phaseCorrelate(before, image, _window(height, width))
    candidates = [(u, v) for u in (x, x - width * _sign(x)) for v in (y, y - height * _sign(y))]
    best = CoarseShift(0.0, 0.0, -1.0)
    for u, v in candidates:
        correlation = overlap_correlation(before, image, round(u), round(v))
        if correlation > best.correlation:
            best = CoarseShift(u, v, correlation)
    return best


def overlap_correlation(before: SmallImage, image: SmallImage, shift_x: int, shift_y: int) -> float:
    """Normalised correlation, -1..1, of what two images both see; -1 when that is too little."""
    a, b = overlapping(before, image, shift_x, shift_y)
    if a.size < _MIN_OVERLAP * image.size:
        return -1.0
    a, b = a - a.mean(), b - b.mean()
    norm = float(np.sqrt(np.vdot(a, a) * np.vdot(b, b)))
    return float(np.vdot(a, b)) / norm if norm > 0.0 else -1.0


def _sign(value: float) -> float:
    return 1.0 if value >= 0.0 else -1.0
