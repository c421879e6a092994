"""One image against one key frame, from a predicted pose: the pose it gives, or why it gives none."""

from dataclasses import dataclass
from math import hypot

import numpy as np

from common.configuration import Tracker
from common.visual_sample import TrackingStatus
from supervisor.tracking.displacement import Matrix
from supervisor.tracking.features import Points
from supervisor.tracking.flow import inside, matched_points, possible_levels
from supervisor.tracking.key_frame import KeyFrame
from supervisor.tracking.photometry import equalised, gain_and_offset
from supervisor.tracking.pose import Pose, pose_since, total_pose
from supervisor.tracking.prepared_image import PreparedImage, reduced
from supervisor.tracking.rigid_displacement import fit_rigid

MAX_SCALE_PX = 1.0  # features that scatter more do not tell of one rigid motion
MAX_STD_PX = 0.5
MIN_AGREEING = 0.5  # of the matched ones
MIN_AGREEING_IN_VIEW = 0.25  # of those that should be in view
_HALF = np.float32(0.5)  # a pixel's middle
RETRY_VIEW_PX = 24.0  # how far the prediction may be off for a feature still to be tried


@dataclass(frozen=True, slots=True)
class Measurement:
    """status MEASURED: pose since the first frame and its covariance, the key frame's included; else neither
    counts."""

    status: TrackingStatus
    key: KeyFrame
    pose: Pose
    covariance: Matrix
    features: int
    inliers: int


def nothing_found(key: KeyFrame, predicted: Pose) -> Measurement:
    """What is said of an image in which it was not worth looking for features."""
    return Measurement(TrackingStatus.FEW_FEATURES, key, predicted, np.full((3, 3), np.nan), 0, 0)


def measure(
    key: KeyFrame, image: PreparedImage, predicted: Pose, config: Tracker, levels: int, shrink: int = 1
) -> Measurement:
    """Track the key frame's features into the image, starting from the predicted pose since the first frame.

    shrink: by how much both images are reduced before. Motion blur of 20 px and more leaves nothing in a
    window that looks like the sharp key frame; in an image of a quarter the size it is 5 px. The scatter
    allowed grows with it.
    """

    def without(status: TrackingStatus, inliers: int = 0) -> Measurement:
        return Measurement(status, key, predicted, np.full((3, 3), np.nan), visible, inliers)

    start = key.predicted_points(predicted)
    margin = config.window_px // 2 - RETRY_VIEW_PX
    chosen = inside(start, image.grey.shape, margin)
    visible = int(np.count_nonzero(inside(start, image.grey.shape, config.window_px // 2)))
    if np.count_nonzero(chosen) < config.min_inliers:
        return without(TrackingStatus.FEW_FEATURES)
    since = pose_since(key.pose, predicted)
    reduction = image.reduction
    gain, offset = gain_and_offset(
        key.image.coarse, image.coarse, round(since.x / reduction), round(since.y / reduction)
    )
    before, now = reduced(key.image.grey, shrink), reduced(equalised(image.grey, gain, offset), shrink)
    moved, good = matched_points(
        before,
        now,
        _shrunk(key.points[chosen], shrink),
        _shrunk(start[chosen], shrink),
        config.window_px,
        possible_levels(now.shape, config.window_px, levels),
        config.forward_backward_px,
    )
    moved = (moved + _HALF) * shrink - _HALF
    matched = int(np.count_nonzero(good))
    if matched < config.min_inliers:
        return without(TrackingStatus.FEW_FEATURES)
    centre = np.array(key.centre)
    fit = fit_rigid(key.points[chosen][good] - centre, moved[good] - centre, since.rotation)
    if fit is None:
        return without(TrackingStatus.INCONSISTENT)
    covariance = fit.covariance * shrink**2  # windows that overlap so much more do not err independently
    std = hypot(*np.sqrt(np.diag(covariance)[:2]))
    pose = total_pose(key.pose, Pose(fit.dx, fit.dy, fit.rotation))
    in_view = int(np.count_nonzero(key.in_view(pose, config.window_px // 2)))
    if (
        fit.inliers < max(config.min_inliers, MIN_AGREEING * matched, MIN_AGREEING_IN_VIEW * in_view)
        or fit.scale > MAX_SCALE_PX * shrink
        or std > MAX_STD_PX * shrink
    ):
        return without(TrackingStatus.INCONSISTENT, fit.inliers)
    return Measurement(
        TrackingStatus.MEASURED,
        key,
        pose,
        key.covariance + covariance,
        max(in_view, fit.inliers),
        fit.inliers,
    )


def _shrunk(points: Points, factor: int) -> Points:
    return np.asarray((points + _HALF) / factor - _HALF, dtype=np.float32)
