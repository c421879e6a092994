"""Images hardly larger than a window."""

import numpy as np
import pytest

from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.common.files.configuration import Tracker
from stillarm.supervisor.tracking.tracker import FeatureTracker
from tests.fixtures.sinusoid_scene import SinusoidScene, photographed


@pytest.mark.parametrize("shape", [(64, 64), (40, 200), (300, 36), (48, 48)])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_small_image_is_measured(shape, seed):
    scene, random, tracker = SinusoidScene(seed), np.random.default_rng(seed), FeatureTracker(Tracker())
    for x in 3.0 * np.sin(0.25 * np.arange(15)):
        found = tracker.track(photographed(scene.at(x, 0.5 * x, shape=shape), random))
        assert found.status == TrackingStatus.MEASURED
        assert abs(found.dx - x) < 0.05 and abs(found.dy - 0.5 * x) < 0.05


def test_windows_are_as_configured_again_after_a_restart():
    scene, random, tracker = SinusoidScene(3), np.random.default_rng(3), FeatureTracker(Tracker())
    tracker.track(photographed(scene.at(0, 0, shape=(36, 36)), random))
    tracker.restart()
    large, other = FeatureTracker(Tracker()), np.random.default_rng(4)
    for x in (0.0, 1.5):
        image = photographed(scene.at(x, 0, shape=(160, 200)), other)
        first, second = tracker.track(image), large.track(image)
    assert (first.dx, first.dy, first.features) == (second.dx, second.dy, second.features)
