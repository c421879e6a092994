"""Where the scene is, to a few px, when prediction has failed: normalised correlation of small images at
every shift.

Padfield, Masked object registration in the Fourier domain, IEEE TIP 2012: means and variances are those of
what both images see at each shift, so that large shifts, with a small common part, are found as well. (Phase
correlation lost the scene at a quarter of the image.) A small common part correlates by chance more easily:
the score is the correlation times the square root of the share in common. The best shift is only a start:
Lucas-Kanade has to confirm it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from supervisor.tracking.photometry import overlapping
from supervisor.tracking.prepared_image import SmallImage

MIN_COMMON = 0.12  # share of the image


class CoarseShift(NamedTuple):
    """x, y: motion of the scene in px of the small image; score: correlation * sqrt(share in
    common), -1..1.
    """

    x: int
    y: int
    score: float


def coarse_shift(before: SmallImage, image: SmallImage) -> CoarseShift:
    """By how much the scene of `before` has moved in `image`; both float32 of one shape."""
    height, width = image.shape
    padded = 2 * height, 2 * width
    a, b = before - before.mean(), image - image.mean()
    ones = np.ones_like(a)
    fa, fa2, fb, fb2, f1 = (np.fft.rfft2(v, padded) for v in (a, a * a, b, b * b, ones))

    def sums(left: NDArray[np.complex128], right: NDArray[np.complex128]) -> NDArray[np.float64]:
        return np.asarray(np.fft.irfft2(left.conj() * right, padded), dtype=np.float64)

    count = np.maximum(np.rint(sums(f1, f1)), 1.0)
    sum_a, sum_b = sums(fa, f1), sums(f1, fb)
    covariance = sums(fa, fb) - sum_a * sum_b / count
    variance = (sums(fa2, f1) - sum_a**2 / count) * (sums(f1, fb2) - sum_b**2 / count)
    common = count / image.size
    smallest = 1e-6 * (float(np.vdot(a, a)) * float(np.vdot(b, b)) + 1e-9)  # below it, rounding
    sound = (common >= MIN_COMMON) & (variance > smallest)
    score = np.where(sound, covariance / np.sqrt(np.maximum(variance, smallest)) * np.sqrt(common), -1.0)
    y, x = np.unravel_index(int(np.argmax(score)), score.shape)
    best = float(score[y, x])
    return CoarseShift(int(x) - padded[1] * (x >= width), int(y) - padded[0] * (y >= height), best)


def overlap_score(before: SmallImage, image: SmallImage, shift_x: int, shift_y: int) -> float:
    """The same score at one shift; -1 when too little is in common."""
    a, b = overlapping(before, image, shift_x, shift_y)
    if a.size < MIN_COMMON * image.size:
        return -1.0
    a, b = a - a.mean(), b - b.mean()
    norm = float(np.sqrt(np.vdot(a, a) * np.vdot(b, b)))
    return float(np.vdot(a, b)) / norm * float(np.sqrt(a.size / image.size)) if norm > 0.0 else -1.0
