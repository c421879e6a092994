"""Key frames: the references for tracking, and the choice among them.

A key frame's pose is the displacement measured in the frame from which it was taken, so that changing to it causes
no step. The error of that measurement remains in the pose: over n key frames it grows as the square root of n, and
the key frame's covariance includes it. Key frames are therefore few and as far apart as the view allows. An older
key frame has a smaller error, and is used again as soon as enough of it is in view: the same pose then gives the
same number. "Sure" means small variance.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.supervisor.tracking.displacement import Matrix
from stillarm.supervisor.tracking.matching.features import Points, spread_corners
from stillarm.supervisor.tracking.matching.flow import inside
from stillarm.supervisor.tracking.matching.interpolation_bias import interpolation_bias
from stillarm.supervisor.tracking.matching.prepared_image import GreyImage, PreparedImage
from stillarm.supervisor.tracking.pose import Pose, pose_since, turned

MAX_KEY_FRAMES = 24
LEAVE_VIEW = 0.5  # share of a key frame's features in view, below which another key frame is needed
RETURN_VIEW = 0.7  # share in view at which an older one is used again; the gap keeps them from alternating
ANCHOR_VIEW = 0.15  # share in view that is enough for a single measurement
LEAVE_ROTATION_RAD = 0.045  # beyond this, square windows match worse, and fail in fine texture
RETURN_ROTATION_RAD = 0.025


@dataclass(frozen=True, slots=True)
class KeyFrame:
    """A prepared image with its features and its pose.

    points: its features, (n, 2) px; arms: the same relative to the image's centre
    pose: since the first frame; covariance: of the pose, (3, 3)
    serial: number of key frames taken before it; bias: result of interpolation_bias()
    """

    image: PreparedImage
    points: Points
    arms: NDArray[np.float64]
    pose: Pose
    covariance: Matrix
    serial: int
    bias: tuple[float, float] = (0.0, 0.0)

    @property
    def variance(self) -> float:
        """Variance of the pose's x plus that of its y, px^2."""
        return float(self.covariance[0, 0] + self.covariance[1, 1])

    @property
    def centre(self) -> tuple[float, float]:
        """The image's centre, x, y in px."""
        return centre(self.image.grey)

    def predicted_points(self, pose: Pose) -> Points:
        """Positions of the features in the image, (n, 2) px, for a scene at `pose` (since the first frame)."""
        since = pose_since(self.pose, pose)
        x0, y0 = self.centre
        c, s = turned(1.0, 0.0, since.rotation)
        moved = self.arms @ np.array([[c, s], [-s, c]]) + (x0 + since.x, y0 + since.y)
        return np.asarray(moved, dtype=np.float32)

    def in_view(self, pose: Pose, margin_px: float) -> NDArray[np.bool_]:
        """Which features are in the image for a scene at `pose`."""
        return inside(self.predicted_points(pose), self.image.grey.shape, margin_px)

    def view(self, pose: Pose, margin_px: float) -> float:
        """Share of the features that are in the image for a scene at `pose`."""
        return float(self.in_view(pose, margin_px).mean())

    def turned_by(self, pose: Pose) -> float:
        """Rotation of the scene relative to this key frame, rad, 0 or more."""
        return abs(pose.rotation - self.pose.rotation)


def take_key_frame(
    image: PreparedImage,
    pose: Pose,
    covariance: Matrix,
    serial: int,
    count: int,
    window_px: int,
    smeared: bool,
) -> KeyFrame:
    """A key frame of an image whose pose has been measured, with up to `count` new features.

    smeared: the image has no texture fine enough for an interpolation bias, which is then not measured.
    """
    points = spread_corners(image.grey, count, window_px // 2 + 1)
    arms = points - np.array(centre(image.grey))
    bias = (0.0, 0.0) if smeared else interpolation_bias(image.grey, points, window_px)
    return KeyFrame(image, points, arms, pose, covariance, serial, bias)


def centre(image: GreyImage) -> tuple[float, float]:
    """The image's centre, x, y in px."""
    height, width = image.shape
    return 0.5 * (width - 1), 0.5 * (height - 1)


class KeyFrames:
    """A bounded set of key frames, oldest first. The first one is the origin and is never dropped."""

    def __init__(self, margin_px: float) -> None:
        """margin_px: distance from the border, within which a feature does not count as in view."""
        self._margin = margin_px
        self.frames: list[KeyFrame] = []

    def add(self, frame: KeyFrame) -> None:
        """Keep a key frame. If there are too many, drop the one (not the first) nearest in pose to another one."""
        self.frames.append(frame)
        if len(self.frames) <= MAX_KEY_FRAMES:
            return
        poses = np.array([(f.pose.x, f.pose.y) for f in self.frames])
        apart = np.hypot(*(poses[:, None, :] - poses[None, :, :]).transpose(2, 0, 1))
        np.fill_diagonal(apart, np.inf)
        crowded = apart[1:-1].min(axis=1)  # neither the origin nor the one just taken
        del self.frames[1 + int(np.argmin(crowded))]

    def surer(self, current: KeyFrame, pose: Pose) -> KeyFrame | None:
        """The well visible key frame of least variance at `pose`, if that is less than the variance of `current`."""
        if all(f.variance >= current.variance for f in self.frames):
            return None
        best = self.best_other(current, pose)
        return best if best is not None and best.variance < current.variance else None

    def best_other(self, current: KeyFrame, pose: Pose) -> KeyFrame | None:
        """The well visible key frame of least variance at `pose`, other than `current`; None if there is none."""
        return self._surest(current, pose, RETURN_VIEW, RETURN_ROTATION_RAD)

    def anchor(self, current: KeyFrame, pose: Pose) -> KeyFrame | None:
        """The partly visible key frame of least variance at `pose`, other than `current`."""
        return self._surest(current, pose, ANCHOR_VIEW, LEAVE_ROTATION_RAD)

    def _surest(self, current: KeyFrame, pose: Pose, view: float, rotation: float) -> KeyFrame | None:
        for frame in sorted(self.frames, key=lambda f: (f.variance, f.serial)):
            near = frame is not current and frame.turned_by(pose) < rotation
            if near and frame.view(pose, self._margin) >= view:
                return frame
        return None

    def most_in_view(self, pose: Pose) -> KeyFrame:
        """The key frame with most features in view at `pose`; the older one of equals. Needs at least one."""
        return max(self.frames, key=lambda f: (round(f.view(pose, self._margin), 2), -f.serial))

    def leaves(self, frame: KeyFrame, pose: Pose) -> bool:
        """Whether so little of `frame` is in view at `pose`, or it is turned so far, that another one is needed."""
        return frame.view(pose, self._margin) < LEAVE_VIEW or frame.turned_by(pose) > LEAVE_ROTATION_RAD
