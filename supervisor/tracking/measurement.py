"""Measures one image against one key frame from a predicted pose: the pose, or the reason why there is none."""

from dataclasses import dataclass
from math import hypot

import numpy as np
from numpy.typing import NDArray

from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.common.files.configuration import Tracker
from stillarm.supervisor.tracking.displacement import Matrix
from stillarm.supervisor.tracking.key_frame import KeyFrame
from stillarm.supervisor.tracking.matching.features import Points
from stillarm.supervisor.tracking.matching.flow import (
    inside,
    median_motion,
    possible_levels,
    returned_points,
    tracked_points,
)
from stillarm.supervisor.tracking.matching.interpolation_bias import bias_variance
from stillarm.supervisor.tracking.matching.photometry import equalised, gain_and_offset
from stillarm.supervisor.tracking.matching.prepared_image import GreyImage, PreparedImage, reduced
from stillarm.supervisor.tracking.matching.rigid_displacement import fit_rigid
from stillarm.supervisor.tracking.pose import Pose, pose_since, total_pose

MAX_SCALE = 1.0 / 640.0  # of the image's longer side: features that scatter more do not show one rigid motion
MAX_SCALE_SMALL_PX = 1.0  # lower bound of that limit
MAX_STD = 0.5  # of the allowed scatter
MIN_AGREEING = 0.5  # of the matched features
MIN_AGREEING_IN_VIEW = 0.25  # of those that should be in view
UNSTEADY_LEVELS = 1  # levels of the pyramid: enough for 10 px
FEW = 40  # features: with fewer, agreement of a quarter of those in view would be no evidence
MIN_HALF_PX = 120  # side of the half-size image above which the backward check in it saves time
ASK_AGAIN = 0.2  # share of points that fail in it, above which the full image decides
_HALF = np.float32(0.5)  # a pixel's middle
RETRY_VIEW_PX = 24.0  # prediction error up to which a feature is still tried


@dataclass(frozen=True, slots=True)
class Measurement:
    """Result of one comparison. If status is MEASURED: the pose since the first frame, and its covariance including
    the key frame's. Otherwise neither is valid."""

    status: TrackingStatus
    key: KeyFrame
    pose: Pose
    covariance: Matrix
    features: int
    inliers: int
    stretch: float = 0.0  # scatter of the features about the rigid motion, as a share of the allowed scatter


def nothing_found(key: KeyFrame, predicted: Pose) -> Measurement:
    """The result for an image in which no features were searched for."""
    return Measurement(TrackingStatus.FEW_FEATURES, key, predicted, np.full((3, 3), np.nan), 0, 0)


def measure(
    key: KeyFrame,
    image: PreparedImage,
    predicted: Pose,
    config: Tracker,
    levels: int,
    shrink: int = 1,
    few: bool = False,
) -> Measurement:
    """Track the key frame's features into the image, starting from the predicted pose since the first frame.

    shrink: factor by which both images are reduced first. Motion blur of 20 px and more leaves nothing in a window
        that resembles the sharp key frame; in an image of a quarter the size it is 5 px. The allowed scatter grows
        with this factor.
    few: use only a part of the features, to find out whether the scene is in view at all.
    """

    def without(status: TrackingStatus, inliers: int = 0) -> Measurement:
        return Measurement(status, key, predicted, np.full((3, 3), np.nan), visible, inliers)

    start = key.predicted_points(predicted)
    margin = config.window_px // 2 - RETRY_VIEW_PX
    part = slice(None, None, max(1, len(start) // max(FEW, 3 * config.min_inliers)) if few else 1)
    chosen = np.zeros(len(start), np.bool_)
    chosen[part] = inside(start[part], image.grey.shape, margin)
    visible = int(np.count_nonzero(inside(start[part], image.grey.shape, config.window_px // 2)))
    if np.count_nonzero(chosen) < config.min_inliers:
        return without(TrackingStatus.FEW_FEATURES)
    since = pose_since(key.pose, predicted)
    reduction = image.reduction
    gain, offset = gain_and_offset(
        key.image.coarse, image.coarse, round(since.x / reduction), round(since.y / reduction)
    )
    pair = _Pair(key.image, image, gain, offset, shrink)
    moved, good = pair.matched(
        _shrunk(key.points[chosen], shrink), _shrunk(start[chosen], shrink), config, levels
    )
    moved = (moved + _HALF) * shrink - _HALF
    matched = int(np.count_nonzero(good))
    if matched < config.min_inliers:
        return without(TrackingStatus.FEW_FEATURES)
    fit = fit_rigid(key.arms[chosen][good], moved[good] - np.array(key.centre), since.rotation)
    if fit is None:
        return without(TrackingStatus.INCONSISTENT)
    covariance = fit.covariance * shrink**2  # windows that overlap so much more have correlated errors
    if shrink == 1:
        covariance[0, 0] += bias_variance(key.bias[0], fit.dx)
        covariance[1, 1] += bias_variance(key.bias[1], fit.dy)
    allowed = max(MAX_SCALE * max(image.grey.shape), MAX_SCALE_SMALL_PX) * shrink
    std = hypot(*np.sqrt(np.diag(covariance)[:2]))
    pose = total_pose(key.pose, Pose(fit.dx, fit.dy, fit.rotation))
    in_view = int(np.count_nonzero(key.in_view(pose, config.window_px // 2)[part]))
    if (
        fit.inliers < max(config.min_inliers, MIN_AGREEING * matched, MIN_AGREEING_IN_VIEW * in_view)
        or fit.scale > allowed
        or std > MAX_STD * allowed
    ):
        return without(TrackingStatus.INCONSISTENT, fit.inliers)
    return Measurement(
        TrackingStatus.MEASURED,
        key,
        pose,
        key.covariance + covariance,
        max(in_view, fit.inliers),
        fit.inliers,
        fit.scale / allowed,
    )


def measure_warily(
    key: KeyFrame, image: PreparedImage, predicted: Pose, config: Tracker, levels: int
) -> Measurement:
    """As measure(), if success is doubtful: first with a few features, and with all of them only if those agree."""
    few = measure(key, image, predicted, config, levels, few=True)
    return measure(key, image, few.pose, config, 0) if few.status == TrackingStatus.MEASURED else few


class _Pair:
    """The two images between which features are matched: photometrically corrected, and reduced by `shrink`."""

    def __init__(
        self, key: PreparedImage, image: PreparedImage, gain: float, offset: float, shrink: int
    ) -> None:
        self._before = reduced(key.grey, shrink)
        self._now = equalised(reduced(image.grey, shrink), gain, offset)
        self._halves: tuple[GreyImage, GreyImage] | None = None
        if shrink == 1 and min(image.half.shape) >= MIN_HALF_PX:
            self._halves = key.half, equalised(image.half, gain, offset)

    def matched(
        self, points: Points, predicted: Points, config: Tracker, levels: int
    ) -> tuple[Points, NDArray[np.bool_]]:
        """The positions of the points, and which of them were found and passed the backward check.

        The backward check to half a px works in images of half the size, in a quarter of the time. If the texture
        is too fine for those, good points fail there, and the check is repeated for them in the full image.
        """
        window, limit = config.window_px, config.forward_backward_px
        possible = possible_levels(self._now.shape, window, levels)
        moved, found = tracked_points(self._before, self._now, points, predicted, window, possible)
        motion = median_motion(points, moved, found)
        good = np.zeros_like(found)
        if self._halves is not None:
            here, there, small = _shrunk(points, 2), _shrunk(moved, 2), window // 2 | 1
            good = returned_points(*self._halves, here, there, found, motion * _HALF, small, limit / 2)
        left = found & ~good
        if np.count_nonzero(left) > ASK_AGAIN * np.count_nonzero(found):
            good |= returned_points(self._before, self._now, points, moved, left, motion, window, limit)
        return moved, good


def _shrunk(points: Points, factor: int) -> Points:
    return np.asarray((points + _HALF) / factor - _HALF, dtype=np.float32)
