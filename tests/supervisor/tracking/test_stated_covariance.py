"""The stated covariance holds the whole error, the interpolation's included."""

import numpy as np
import pytest

from stillarm.common.files.configuration import Tracker
from stillarm.supervisor.tracking.tracker import FeatureTracker
from tests.fixtures.sinusoid_scene import SinusoidScene, photographed


@pytest.mark.slow
@pytest.mark.parametrize("shortest", [4.0, 6.0, 10.0])
def test_normalised_error_squared_averages_to_about_one(shortest):
    ratios = []
    for seed in (1, 2):
        scene, random, tracker = (
            SinusoidScene(seed, shortest),
            np.random.default_rng(5),
            FeatureTracker(Tracker()),
        )
        for i in range(24):
            x, y = 3.0 * np.sin(0.25 * i), 0.7 * np.sin(0.14 * i)
            found = tracker.track(photographed(scene.at(x, y), random))
            if i:
                error = np.array([found.dx - x, found.dy - y])
                ratios.append(error @ np.linalg.solve(found.covariance[:2, :2], error) / 2.0)
    assert 0.5 < np.mean(ratios) < 2.0
