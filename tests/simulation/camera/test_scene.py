"""The scene: band-limited, seeded, endless, and rich enough to be tracked."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.simulation.camera.scene import CUTOFF, Scene, make_scene


@pytest.fixture(scope="module")
def scene() -> Scene:
    return make_scene(640, 480, 1)


def test_nothing_lies_above_the_cutoff(scene: Scene) -> None:
    period = scene.texture[:, : scene.period].astype(np.float64)
    power = np.abs(np.fft.rfft(period - period.mean(), axis=1)) ** 2
    frequency = np.fft.rfftfreq(scene.period)
    assert power[:, frequency > CUTOFF].sum() < 1e-9 * power.sum()
    assert power[:, (frequency > 0.05) & (frequency < 0.15)].sum() > 1e-3 * power.sum()


def test_grey_levels_leave_room_for_the_noise(scene: Scene) -> None:
    assert scene.texture.min() >= 27.0
    assert scene.texture.max() <= 229.0
    assert scene.texture[:, : scene.period].std() > 25.0


@settings(max_examples=50, deadline=None)
@given(first=st.integers(-10_000, 10_000), count=st.integers(1, 3000))
def test_columns_go_on_without_end(scene: Scene, first: int, count: int) -> None:
    columns = scene.columns(first, count)
    assert columns.shape == (480, count)
    expected = scene.texture[:, np.arange(first, first + count) % scene.period]
    np.testing.assert_array_equal(columns, expected)


def test_it_does_not_repeat_within_an_image(scene: Scene) -> None:
    image = scene.columns(0, 640) - 128.0
    for shift in range(64, scene.period - 64, 64):
        other = scene.columns(shift, 640) - 128.0
        correlation = float(np.mean(image * other) / (image.std() * other.std()))
        assert abs(correlation) < 0.35


def test_the_seed_decides() -> None:
    first, again, other = (make_scene(64, 64, seed).texture for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 10.0


@pytest.mark.parametrize("width", [64, 640, 3000])
def test_the_period_is_at_least_twice_the_image(width: int) -> None:
    scene = make_scene(width, 64, 0)
    assert scene.period >= max(4096, 2 * width)


def test_everywhere_there_are_corners_to_track(scene: Scene) -> None:
    for first in range(0, scene.period, 512):
        image = np.ascontiguousarray(scene.columns(first, 640)).astype(np.uint8)
        corners = cv2.goodFeaturesToTrack(image, 100, 0.05, 15)
        assert corners is not None
        assert len(corners) == 100
