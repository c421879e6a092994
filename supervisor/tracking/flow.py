"""Pyramidal Lucas-Kanade from a key frame to the present, with a predicted start and a forward-backward
check."""

import cv2
import numpy as np
from numpy.typing import NDArray

from supervisor.tracking.features import Points
from supervisor.tracking.prepared_image import GreyImage

_CRITERIA = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 20, 0.005)


def possible_levels(shape: tuple[int, ...], window_px: int, levels: int) -> int:
    """How many pyramid levels leave the smallest image no smaller than the window."""
    side = min(shape)
    possible = 0
    while possible < levels and side >> (possible + 1) >= window_px:
        possible += 1
    return possible


def inside(points: Points, shape: tuple[int, ...], margin_px: float) -> NDArray[np.bool_]:
    """Which points, shape (n, 2), lie in the image and no nearer to its border than margin_px."""
    height, width = shape
    x, y = points[:, 0], points[:, 1]
    return np.asarray(
        (x >= margin_px) & (y >= margin_px) & (x <= width - 1 - margin_px) & (y <= height - 1 - margin_px)
    )


def matched_points(
    key: GreyImage,
    image: GreyImage,
    points: Points,
    predicted: Points,
    window_px: int,
    levels: int,
    forward_backward_px: float,
) -> tuple[Points, NDArray[np.bool_]]:
    """Where `points` of `key`, shape (n, 2), are in `image`, and which of them came back to where they
    started.

    The way back starts from the median motion of all points, not from where the point itself came from, or a
    wrong match would confirm itself; so near, the finest level is enough. Windows that reach over the border
    would read
    mirrored pixels: such points are not taken.
    """
    window = (window_px, window_px)
    flags = cv2.OPTFLOW_USE_INITIAL_FLOW
    ahead, found, _ = cv2.calcOpticalFlowPyrLK(
        key, image, points, predicted.copy(), winSize=window, maxLevel=levels, criteria=_CRITERIA, flags=flags
    )
    moved = np.asarray(ahead, dtype=np.float32).reshape(-1, 2)
    missed = np.median((moved - predicted)[found.ravel() == 1], axis=0) if found.any() else np.zeros(2)
    start = moved - (predicted - points) - missed.astype(np.float32)
    back, returned, _ = cv2.calcOpticalFlowPyrLK(
        image, key, moved, start, winSize=window, maxLevel=0, criteria=_CRITERIA, flags=flags
    )
    astray = np.abs(np.asarray(back).reshape(-1, 2) - points).max(axis=1)
    good = (found.ravel() == 1) & (returned.ravel() == 1) & (astray <= forward_backward_px)
    good &= np.isfinite(moved).all(axis=1) & inside(moved, image.shape, window_px // 2)
    return moved, np.asarray(good)
