"""A bad image is flagged."""

import cv2
import numpy as np
import pytest

from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.common.files.configuration import Tracker
from stillarm.supervisor.tracking.tracker import FeatureTracker
from tests.fixtures.sinusoid_scene import SHAPE, SinusoidScene, photographed
from tests.fixtures.tracked_scenes import vibration


def bad_images(scene):
    random = np.random.default_rng(8)
    other = SinusoidScene(99)
    good = photographed(scene.at(0, 0), random)
    return {
        TrackingStatus.NO_IMAGE: None,
        TrackingStatus.DARK: photographed(np.full(SHAPE, 3.0), random),
        TrackingStatus.SATURATED: np.full(SHAPE, 255, np.uint8),
        TrackingStatus.BLANK: photographed(np.full(SHAPE, 120.0), random),
        TrackingStatus.BLURRED: photographed(cv2.GaussianBlur(scene.at(0, 0), (0, 0), 8), random),
        TrackingStatus.JUMPED: photographed(other.at(0, 0), random),
        TrackingStatus.FROZEN: good,
    }


@pytest.mark.slow
@pytest.mark.parametrize("status", list(bad_images(SinusoidScene(1))))
def test_bad_image_is_flagged_and_tracking_resumes(status):
    scene = SinusoidScene(11)
    random = np.random.default_rng(9)
    tracker = FeatureTracker(Tracker())
    bad = bad_images(scene)[status]
    truth = vibration(24)
    for i, (x, y, _) in enumerate(truth):
        if 8 <= i < 13:
            image = bad if bad is None else bad.copy()
            result = tracker.track(image)
            if status == TrackingStatus.FROZEN and i == 8:
                continue  # the first of them is not yet the same again
            wanted = {status, TrackingStatus.FROZEN} if i > 8 else {status}
            assert result.status in wanted
            assert (
                np.isnan([result.dx, result.dy, result.rotation]).all() and np.isnan(result.covariance).all()
            )
        else:
            result = tracker.track(photographed(scene.at(x, y), random))
            assert result.status == TrackingStatus.MEASURED
            assert abs(result.dx - x) < 0.03 and abs(result.dy - y) < 0.03
