"""Selection of features: Shi-Tomasi corners, spread over the image."""

from math import sqrt

import cv2
import numpy as np
from numpy.typing import NDArray

from stillarm.supervisor.tracking.matching.prepared_image import GreyImage

Points = NDArray[np.float32]

_QUALITY = 0.01  # of the strongest corner's smaller eigenvalue
_SPACING = 0.65  # of the spacing of a square grid with as many points


def spread_corners(image: GreyImage, count: int, margin_px: int) -> Points:
    """Up to `count` corners, strongest first, shape (n, 2) as x, y in px, no nearer to the border than
    margin_px.

    Shi and Tomasi, Good features to track, CVPR 1994. A minimum distance spreads the corners:
    a rotation needs a lever arm, and an occluder or a bright lamp must not contain most of them.
    """
    height, width = image.shape
    inner = image[margin_px : height - margin_px, margin_px : width - margin_px]
    if inner.size == 0:
        return np.empty((0, 2), np.float32)
    distance = _SPACING * sqrt(inner.size / count)
    found = cv2.goodFeaturesToTrack(inner, count, _QUALITY, distance, blockSize=5)
    if found is None:
        return np.empty((0, 2), np.float32)
    return np.asarray(found.reshape(-1, 2) + np.float32(margin_px), dtype=np.float32)
