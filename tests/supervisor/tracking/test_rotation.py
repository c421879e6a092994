"""Turning through a tenth of a radian: further than one key frame reaches in fine texture."""

import numpy as np
import pytest

from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.common.files.configuration import Tracker
from stillarm.supervisor.tracking.tracker import FeatureTracker
from tests.fixtures.sinusoid_scene import SinusoidScene, photographed


@pytest.mark.slow
@pytest.mark.parametrize("shortest", [4.0, 10.0])
def test_a_tenth_of_a_radian_there_and_back(shortest):
    scene, random, tracker = SinusoidScene(5, shortest), np.random.default_rng(5), FeatureTracker(Tracker())
    errors = []
    for i in range(48):
        angle = 0.1 * np.sin(0.2 * i)
        found = tracker.track(photographed(scene.at(0, 0, angle), random))
        assert found.status == TrackingStatus.MEASURED
        errors.append((found.dx, found.dy, found.rotation - angle))
    error = np.array(errors)
    assert tracker.key_frames > 1
    assert np.sqrt(np.mean(error[:, 2] ** 2)) < 1e-4 and np.abs(error[:, 2]).max() < 2e-4
    assert np.sqrt(np.mean(error[:, :2] ** 2)) < 0.03 and np.abs(error[:, :2]).max() < 0.06
