"""The tracker's result for one image."""

from dataclasses import dataclass, field
from math import nan

import numpy as np
from numpy.typing import NDArray

from stillarm.common.datagrams.visual_sample import TrackingStatus

Matrix = NDArray[np.float64]


def _unknown() -> Matrix:
    return np.full((3, 3), nan)


@dataclass(frozen=True, slots=True)
class Displacement:
    """Motion of the static scene in the image, relative to the first good frame, at the image's centre.

    dx, dy: px; a scene point that moved right and down in the image has dx > 0 and dy > 0
    rotation: rad, from the x axis towards the y axis (clockwise as displayed)
    covariance: shape (3, 3) of (dx, dy, rotation), px^2, px rad, rad^2
    features: number of the key frame's features that should be in view; inliers: number of those that agreed
    All numbers are NaN unless status is MEASURED.
    """

    status: TrackingStatus
    dx: float = nan
    dy: float = nan
    rotation: float = nan
    covariance: Matrix = field(default_factory=_unknown)
    features: int = 0
    inliers: int = 0
