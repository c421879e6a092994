"""The bias of interpolation: found where texture is fine."""

import numpy as np
import pytest

from stillarm.supervisor.tracking.matching.features import spread_corners
from stillarm.supervisor.tracking.matching.interpolation_bias import bias_variance, interpolation_bias
from tests.fixtures.sinusoid_scene import SinusoidScene, photographed


def test_the_bias_is_found_where_texture_is_fine():
    random = np.random.default_rng(0)
    found = []
    for shortest in (4.0, 20.0):
        image = photographed(SinusoidScene(1, shortest).at(0, 0), random)
        found.append(interpolation_bias(image, spread_corners(image, 100, 11), 21)[0])
    assert found[0] > 0.01 and found[1] < 0.003


def test_the_bias_vanishes_at_whole_and_half_pixels_and_repeats():
    assert bias_variance(0.02, 0.0) == bias_variance(0.02, -3.0) == bias_variance(0.02, 0.5) == 0.0
    assert bias_variance(0.02, 0.21) == pytest.approx(0.02**2) == bias_variance(0.02, -7.79)


def test_nothing_is_claimed_with_too_few_points():
    assert interpolation_bias(np.zeros((64, 64), np.uint8), np.zeros((3, 2), np.float32), 21) == (0.0, 0.0)
