"""The error of Lucas-Kanade's bilinear interpolation in a given texture, measured on the image itself.

Bilinear interpolation flattens fine texture. It makes a displacement too large just above a whole pixel and too
small just below the next. Features lie on whole pixels and move alike, so they all have the same error. Their
scatter, from which the covariance is computed, does not show it. To lowest order in the texture's wave number k

    error(f) = k^2 / 6  f (1 - f) (1 - 2 f),      f = displacement modulo 1 px

To measure its size, the image is shifted with a windowed sinc by 0.21 px, where the error is largest, and tracked.
"""

from math import floor, sqrt

import cv2
import numpy as np
from numpy.typing import NDArray

from stillarm.supervisor.tracking.matching.features import Points
from stillarm.supervisor.tracking.matching.flow import inside, tracked_points
from stillarm.supervisor.tracking.matching.prepared_image import GreyImage

_SHIFT_PX = 0.21
_HALF_TAPS = 6
_CROP_PX = (320, 240)  # this part of the image's middle is enough
_FEWEST = 10
_NOISE_PX = 0.004  # apparent error from sensor noise of 2 grey levels, which is shifted with the image


def _shift_taps() -> NDArray[np.float64]:
    at = np.arange(-_HALF_TAPS, _HALF_TAPS + 1) + _SHIFT_PX
    taps = np.sinc(at) * np.sinc(at / (_HALF_TAPS + 0.5))
    return np.asarray(taps / taps.sum())


_TAPS = _shift_taps()


def interpolation_bias(image: GreyImage, points: Points, window_px: int) -> tuple[float, float]:
    """The error in x and in y at a displacement of 0.21 px, px, 0 or more; 0 if there are too few points."""
    height, width = image.shape
    x, y = max(0, (width - _CROP_PX[0]) // 2), max(0, (height - _CROP_PX[1]) // 2)
    margin = window_px // 2 + _HALF_TAPS
    crop, part = image[y : height - y, x : width - x], points - np.array([x, y], np.float32)
    part = part[inside(part, crop.shape, margin)]
    if len(part) < _FEWEST:
        crop, part = image, points[inside(points, image.shape, margin)]
    if len(part) < _FEWEST:
        return 0.0, 0.0
    shifted = np.asarray(cv2.sepFilter2D(crop, -1, _TAPS, _TAPS), dtype=np.uint8)
    moved, found = tracked_points(crop, shifted, part, part + np.float32(_SHIFT_PX), window_px, 0)
    if np.count_nonzero(found) < _FEWEST:
        return 0.0, 0.0
    error = np.median((moved - part)[found], axis=0) - _SHIFT_PX
    off_x, off_y = (sqrt(max(0.0, float(e) ** 2 - _NOISE_PX**2)) for e in error)
    return off_x, off_y


def bias_variance(bias_px: float, displacement_px: float) -> float:
    """Squared error at a displacement, px^2. bias_px: interpolation_bias() of its axis."""
    return (bias_px * _shape(displacement_px - floor(displacement_px)) / _shape(_SHIFT_PX)) ** 2


def _shape(fraction: float) -> float:
    return fraction * (1.0 - fraction) * (1.0 - 2.0 * fraction)
