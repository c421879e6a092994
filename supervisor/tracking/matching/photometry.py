"""Gain and offset of an image relative to a key frame, so that flicker does not bias Lucas-Kanade.

Lucas-Kanade assumes equal grey values. A gain change of 8 % biased it by 0.04 px.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from stillarm.supervisor.tracking.matching.prepared_image import GreyImage, SmallImage

_MAX_SAMPLES = 1200
_MIN_SAMPLES = 64
_MIN_SPREAD = 0.5  # grey levels: with less there is no texture to compare
_NO_CHANGE = 1.0, 0.0


def overlapping(a: SmallImage, b: SmallImage, shift_x: int, shift_y: int) -> tuple[SmallImage, SmallImage]:
    """The common parts of two images of the same shape, if b shows a's scene moved by the shift, in px."""
    height, width = a.shape
    x0, x1 = max(0, shift_x), min(width, width + shift_x)
    y0, y1 = max(0, shift_y), min(height, height + shift_y)
    if x0 >= x1 or y0 >= y1:
        return a[:0, :0], b[:0, :0]
    return a[y0 - shift_y : y1 - shift_y, x0 - shift_x : x1 - shift_x], b[y0:y1, x0:x1]


def gain_and_offset(key: SmallImage, image: SmallImage, shift_x: int, shift_y: int) -> tuple[float, float]:
    """gain, offset such that image = gain * key + offset over the common part, without outlying pixels.

    The gain is the ratio of the standard deviations: a slightly wrong shift would lower the slope of a regression.
    Returns (1, 0) if the common part is too small.
    """
    a, b = overlapping(key, image, shift_x, shift_y)
    step = max(1, int(np.sqrt(a.size / _MAX_SAMPLES)))
    x, y = a[::step, ::step].ravel(), b[::step, ::step].ravel()
    if x.size < _MIN_SAMPLES:
        return _NO_CHANGE
    median_x, median_y = _median(x), _median(y)
    spread_x, spread_y = _median(np.abs(x - median_x)), _median(np.abs(y - median_y))
    if min(spread_x, spread_y) < _MIN_SPREAD:
        return _NO_CHANGE
    gain = spread_y / spread_x
    offset = median_y - gain * median_x
    for _ in range(2):
        residual = np.abs(y - gain * x - offset)
        agree = residual <= max(4.0 * _median(residual), 2.0)
        mean_x, deviation_x = _mean_and_deviation(x, agree)
        mean_y, deviation_y = _mean_and_deviation(y, agree)
        if np.count_nonzero(agree) < _MIN_SAMPLES or deviation_x < _MIN_SPREAD:
            return _NO_CHANGE
        gain = deviation_y / deviation_x
        offset = mean_y - gain * mean_x
    return (gain, offset) if 0.2 < gain < 5.0 else _NO_CHANGE


def _mean_and_deviation(values: NDArray[np.float32], chosen: NDArray[np.bool_]) -> tuple[float, float]:
    mean, deviation = cv2.meanStdDev(values, mask=chosen.view(np.uint8))
    return float(mean[0, 0]), float(deviation[0, 0])


def _median(values: NDArray[np.float32]) -> float:
    middle = values.size // 2
    return float(np.partition(values, middle)[middle])


def equalised(image: GreyImage, gain: float, offset: float) -> GreyImage:
    """The image corrected to gain 1 and offset 0; unchanged if the difference is below the rounding of grey levels."""
    if abs(gain - 1.0) < 0.002 and abs(offset) < 0.3:
        return image
    return np.asarray(cv2.addWeighted(image, 1.0 / gain, image, 0.0, -offset / gain), dtype=np.uint8)
