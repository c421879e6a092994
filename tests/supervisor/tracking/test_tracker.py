"""The tracker on a scene whose displacement is known exactly."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.common.files.configuration import Tracker
from stillarm.supervisor.tracking.displacement import Displacement
from stillarm.supervisor.tracking.tracker import UNCONFIRMED_FRAMES, FeatureTracker, warm_up
from tests.fixtures.sinusoid_scene import SHAPE, SinusoidScene, photographed
from tests.fixtures.tracked_scenes import move, rms, tracked, vibration


@pytest.mark.slow
@pytest.mark.parametrize("shortest", [4.0, 10.0])
def test_subpixel_vibration(shortest):
    error, results, tracker = tracked(vibration(), SinusoidScene(1, shortest))
    assert rms(error[:, :2]) < 0.012
    assert tracker.key_frames == 1
    assert all(r.inliers > 80 for r in results)


@pytest.mark.slow
def test_occluder_over_a_sixth():
    assert rms(tracked(vibration(), SinusoidScene(3), occluder=True)[0][:, :2]) < 0.012


def test_rotation():
    truth = np.zeros((30, 3))
    truth[:, 2] = 0.05 * np.sin(0.2 * np.arange(30))
    error, _, _ = tracked(truth, SinusoidScene(4))
    assert rms(error[:, 2]) < 1e-4
    assert rms(error[:, :2]) < 0.03


@pytest.mark.slow
def test_fast_move_with_motion_blur():
    there = move(500.0, 0.5, 65)
    smear = 0.9 * np.gradient(there[:, :2], axis=0)
    assert smear.max() > 25.0
    error, results, _ = tracked(there, SinusoidScene(1), smear=smear)
    assert all(r.status == TrackingStatus.MEASURED for r in results)
    assert np.abs(error[:, :2]).max() < 1.0
    assert np.abs(error[-5:, :2]).max() < 0.1  # sharp again: the error of smeared key frames has been mended


def test_covariance_is_of_the_errors_size():
    error, results, _ = tracked(vibration(), SinusoidScene(7, 10.0))
    std = np.median([np.sqrt(r.covariance[0, 0]) for r in results[1:]])
    assert 0.3 < rms(error[1:, 0]) / std < 4.0


def test_found_again_elsewhere_after_a_gap():
    scene, random = SinusoidScene(12), np.random.default_rng(1)
    tracker = FeatureTracker(Tracker())
    for _ in range(3):
        tracker.track(photographed(scene.at(0, 0), random))
    for _ in range(20):
        assert tracker.track(photographed(np.zeros(SHAPE), random)).status == TrackingStatus.DARK
    result = tracker.track(photographed(scene.at(-170.4, 60.2), random))
    assert result.status == TrackingStatus.MEASURED
    assert abs(result.dx + 170.4) < 0.03 and abs(result.dy - 60.2) < 0.03


def test_a_scene_that_replaces_another_stays_flagged_until_restart():
    old, new, random = SinusoidScene(13), SinusoidScene(14), np.random.default_rng(1)
    tracker = FeatureTracker(Tracker())
    for _ in range(4):
        tracker.track(photographed(old.at(0, 0), random))
    for i in range(25):
        assert tracker.track(photographed(new.at(i, 0), random)).status != TrackingStatus.MEASURED
    tracker.restart()
    assert tracker.track(photographed(new.at(0, 0), random)).dx == 0.0
    assert abs(tracker.track(photographed(new.at(1.5, 0), random)).dx - 1.5) < 0.03


def test_a_first_frame_that_nothing_confirms_is_no_origin():
    test_image, scene, random = SinusoidScene(15), SinusoidScene(16), np.random.default_rng(1)
    tracker = FeatureTracker(Tracker())
    tracker.track(photographed(test_image.at(0, 0), random))
    results = [tracker.track(photographed(scene.at(0, 0), random)) for _ in range(UNCONFIRMED_FRAMES + 3)]
    assert [r.status == TrackingStatus.MEASURED for r in results[-4:]] == [True] * 4


def test_half_of_the_image_goes_its_own_way():
    scene, other, random = SinusoidScene(17), SinusoidScene(18), np.random.default_rng(1)
    tracker = FeatureTracker(Tracker())
    tracker.track(photographed(scene.at(0, 0), random))
    for i in range(1, 25):
        torn = np.concatenate([scene.at(2 * np.sin(i), 0)[:250], other.at(i, 0)[250:]])
        result = tracker.track(photographed(torn, random))
        assert result.status != TrackingStatus.MEASURED or abs(result.dx - 2 * np.sin(i)) < 0.05


def test_size_and_kind_of_image():
    scene, random = SinusoidScene(19), np.random.default_rng(1)
    tracker = FeatureTracker(Tracker())
    small = (64, 64)
    assert tracker.track(photographed(scene.at(0, 0, shape=small), random)).status == TrackingStatus.MEASURED
    result = tracker.track(photographed(scene.at(1.2, 0, shape=small), random))
    assert abs(result.dx - 1.2) < 0.05
    for wrong in (
        photographed(scene.at(0, 0), random),
        np.zeros((64, 64, 3), np.uint8),
        np.zeros((64, 64), np.float32),
        np.zeros((0, 0), np.uint8),
    ):
        assert tracker.track(wrong).status == TrackingStatus.NO_IMAGE


def test_the_caller_may_overwrite_the_image():
    scene, random = SinusoidScene(20), np.random.default_rng(1)
    tracker = FeatureTracker(Tracker())
    buffer = photographed(scene.at(0, 0), random)
    tracker.track(buffer)
    buffer[:] = photographed(scene.at(2.5, 0), random)
    assert abs(tracker.track(buffer).dx - 2.5) < 0.03


def test_the_same_images_give_the_same_numbers():
    _, first, _ = tracked(vibration(12), SinusoidScene(21))
    _, second, _ = tracked(vibration(12), SinusoidScene(21))
    assert [(r.dx, r.dy, r.rotation) for r in first] == [(r.dx, r.dy, r.rotation) for r in second]


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    shape=st.tuples(st.integers(64, 120), st.integers(64, 160)),
    kinds=st.lists(st.sampled_from(["noise", "flat", "step", "gradient", "again"]), min_size=2, max_size=6),
)
def test_never_raises_on_any_image(seed, shape, kinds):
    random = np.random.default_rng(seed)
    tracker = FeatureTracker(Tracker())
    image = np.zeros(shape, np.uint8)
    for kind in kinds:
        if kind == "noise":
            image = random.integers(0, 256, shape, dtype=np.uint8)
        elif kind == "flat":
            image = np.full(shape, random.integers(0, 256), np.uint8)
        elif kind == "step":
            image = np.where(np.arange(shape[1]) < random.integers(1, shape[1]), 20, 200) * np.ones(
                (shape[0], 1)
            )
            image = image.astype(np.uint8)
        elif kind == "gradient":
            image = np.add.outer(np.arange(shape[0]), np.arange(shape[1])).astype(np.uint8)
        result = tracker.track(image)
        assert isinstance(result, Displacement)
        finite = np.isfinite([result.dx, result.dy, result.rotation]).all()
        assert finite == (result.status == TrackingStatus.MEASURED)


def test_warm_up_takes_any_size():
    warm_up(Tracker(), 64, 64)
    warm_up(Tracker(levels=0, blur_sigma_px=1.0), 200, 100)
