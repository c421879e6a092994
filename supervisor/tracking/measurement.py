"""One image against one key frame, from a predicted pose: the pose it gives, or why it gives none."""

from dataclasses import dataclass
from math import hypot

import numpy as np

from common.configuration import Tracker
from common.visual_sample import TrackingStatus
from supervisor.tracking.displacement import Matrix
from supervisor.tracking.flow import matched_points, possible_levels
from supervisor.tracking.key_frame import KeyFrame
from supervisor.tracking.photometry import equalised, gain_and_offset
from supervisor.tracking.pose import Pose, pose_since, total_pose
from supervisor.tracking.prepared_image import PreparedImage
from supervisor.tracking.rigid_displacement import fit_rigid

MAX_SCALE_PX = 1.0  # features that scatter more do not tell of one rigid motion
MAX_STD_PX = 0.5
MIN_AGREEING = 0.5  # of the matched ones
MIN_AGREEING_IN_VIEW = 0.25  # of those that should be in view
RETRY_VIEW_PX = 24.0  # how far the prediction may be off for a feature still to be tried


@dataclass(frozen=True, slots=True)
class Measurement:
    """status MEASURED: pose since the first frame and its covariance, the key frame's included; else neither counts."""

    status: TrackingStatus
    key: KeyFrame
    pose: Pose
    covariance: Matrix
    features: int
    inliers: int


def measure(
    key: KeyFrame, image: PreparedImage, predicted: Pose, config: Tracker, levels: int
) -> Measurement:
    """Track the key frame's features into the image, starting from the predicted pose since the first frame."""

    def without(status: TrackingStatus, inliers: int = 0) -> Measurement:
        return Measurement(status, key, predicted, np.full((3, 3), np.nan), visible, inliers)

    start = key.predicted_points(predicted)
    margin = config.window_px // 2 - RETRY_VIEW_PX
    chosen = key.in_view(predicted, margin)
    visible = int(np.count_nonzero(key.in_view(predicted, config.window_px // 2)))
    if np.count_nonzero(chosen) < config.min_inliers:
        return without(TrackingStatus.FEW_FEATURES)
    since = pose_since(key.pose, predicted)
    reduction = image.reduction
    gain, offset = gain_and_offset(
        key.image.coarse, image.coarse, round(since.x / reduction), round(since.y / reduction)
    )
    moved, good = matched_points(
        key.image.grey,
        equalised(image.grey, gain, offset),
        key.points[chosen],
        start[chosen],
        config.window_px,
        possible_levels(image.grey.shape, config.window_px, levels),
        config.forward_backward_px,
    )
    matched = int(np.count_nonzero(good))
    if matched < config.min_inliers:
        return without(TrackingStatus.FEW_FEATURES)
    centre = np.array(key.centre)
    fit = fit_rigid(key.points[chosen][good] - centre, moved[good] - centre)
    if fit is None:
        return without(TrackingStatus.INCONSISTENT)
    std = hypot(*np.sqrt(np.diag(fit.covariance)[:2]))
    pose = total_pose(key.pose, Pose(fit.dx, fit.dy, fit.rotation))
    in_view = int(np.count_nonzero(key.in_view(pose, config.window_px // 2)))
    if (
        fit.inliers < max(config.min_inliers, MIN_AGREEING * matched, MIN_AGREEING_IN_VIEW * in_view)
        or fit.scale > MAX_SCALE_PX
        or std > MAX_STD_PX
    ):
        return without(TrackingStatus.INCONSISTENT, fit.inliers)
    return Measurement(
        TrackingStatus.MEASURED, key, pose, key.covariance + fit.covariance, max(in_view, fit.inliers), fit.inliers
    )
