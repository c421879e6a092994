"""Pyramidal Lucas-Kanade from a key frame to the present image, with a predicted start and a backward check."""

import cv2
import numpy as np
from numpy.typing import NDArray

from stillarm.supervisor.tracking.matching.features import Points
from stillarm.supervisor.tracking.matching.prepared_image import GreyImage

Flags = NDArray[np.bool_]

_CRITERIA = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 12, 0.005)  # iterations, px
_BACK_CRITERIA = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 10, 0.02)  # iterations, px


def possible_levels(shape: tuple[int, ...], window_px: int, levels: int) -> int:
    """How many pyramid levels leave the smallest image no smaller than the window."""
    side = min(shape)
    possible = 0
    while possible < levels and side >> (possible + 1) >= window_px:
        possible += 1
    return possible


def inside(points: Points, shape: tuple[int, ...], margin_px: float) -> Flags:
    """Which points, shape (n, 2), lie in the image and no nearer to its border than margin_px."""
    height, width = shape
    x, y = points[:, 0], points[:, 1]
    return np.asarray(
        (x >= margin_px) & (y >= margin_px) & (x <= width - 1 - margin_px) & (y <= height - 1 - margin_px)
    )


def tracked_points(
    key: GreyImage, image: GreyImage, points: Points, predicted: Points, window_px: int, levels: int
) -> tuple[Points, Flags]:
    """Where `points` of `key`, shape (n, 2), are in `image`, starting from `predicted`, and which were found.

    Windows across the border would read mirrored pixels, so such points do not count as found.
    """
    moved, found = _flow(key, image, points, predicted, window_px, levels, _CRITERIA)
    found &= np.isfinite(moved).all(axis=1)
    return moved, found & inside(moved, image.shape, window_px // 2)


def median_motion(points: Points, moved: Points, found: Flags) -> Points:
    """Median x and y motion in px of the points found, each axis separately; zero if there are none."""
    motion = moved[found] - points[found]
    middle = len(motion) // 2
    return np.partition(motion, middle, axis=0)[middle] if len(motion) else np.zeros(2, np.float32)


def returned_points(
    key: GreyImage,
    image: GreyImage,
    points: Points,
    moved: Points,
    asked: Flags,
    motion: Points,
    window_px: int,
    limit_px: float,
) -> Flags:
    """Which of the points in `asked` track back from `moved` to within limit_px of their start.

    The backward track starts from `motion`, shape (2,), which all points have in common. If it started from the
    point's own origin, a wrong match would confirm itself. So near the answer, the finest level is enough.
    """
    chosen = np.flatnonzero(asked)
    came_back = np.zeros_like(asked)
    if len(chosen):
        here, there = points[chosen], moved[chosen]
        back, returned = _flow(image, key, there, there - motion, window_px, 0, _BACK_CRITERIA)
        came_back[chosen] = returned & (np.abs(back - here).max(axis=1) <= limit_px)
    return came_back


def _flow(
    before: GreyImage,
    after: GreyImage,
    points: Points,
    predicted: Points,
    window_px: int,
    levels: int,
    criteria: tuple[int, int, float],
) -> tuple[Points, Flags]:
    moved, found, _ = cv2.calcOpticalFlowPyrLK(
        before,
        after,
        points,
        predicted.copy(),
        winSize=(window_px, window_px),
        maxLevel=levels,
        criteria=criteria,
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )
    return np.asarray(moved, dtype=np.float32).reshape(-1, 2), np.asarray(found.ravel() == 1)
