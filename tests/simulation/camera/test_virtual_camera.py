"""The camera in virtual time: the same instants with and without images, and the tracker's error model."""

import numpy as np
import pytest

from stillarm.common.files.configuration import Rig, SimulatedScene
from stillarm.common.files.model import Camera, Model
from stillarm.simulation.camera.pose_history import PoseHistory
from stillarm.simulation.camera.virtual_camera import Delivery, VirtualCamera

W = 2.0 * np.pi * 2.6


def _run(
    model: Model, rig: Rig, seed: int, *, images: bool, end_s: float
) -> tuple[VirtualCamera, list[Delivery]]:
    history = PoseHistory(None)
    camera = VirtualCamera(model, rig, seed, history, images=images)
    delivered: list[Delivery] = []
    for cycle in range(round(end_s * 1000)):
        now = 0.001 * cycle
        history.append(now, 0.00625 * float(np.sin(W * now)), 0.0)
        delivered += camera.due(now)
    return camera, delivered


def test_instants_are_the_same_with_and_without_images_and_repeat_with_the_seed() -> None:
    rig = Rig(scene=SimulatedScene(width_px=64, height_px=64))
    with_images, seen = _run(Model(), rig, 4, images=True, end_s=1.0)
    without, unseen = _run(Model(), rig, 4, images=False, end_s=1.0)
    _, other = _run(Model(), rig, 5, images=False, end_s=1.0)
    assert [d.truth for d in seen] == [d.truth for d in unseen]
    assert [d.truth for d in other] != [d.truth for d in unseen]
    assert all(d.image is not None for d in seen)
    assert all(d.image is None for d in unseen)
    frame = seen[5].as_frame()
    assert (frame.counter, frame.exposure_s, frame.stamp_s) == (5, 0.015, None)
    with pytest.raises(ValueError, match="skipped"):
        unseen[5].as_frame()
    for d in unseen:
        assert with_images.tracked_displacement(d.truth.frame) == without.tracked_displacement(d.truth.frame)


def test_the_tracked_displacement_is_the_exposures_mean_plus_the_trackers_noise() -> None:
    history = PoseHistory(None)
    camera = VirtualCamera(Model(camera=Camera(noise_std_px=0.05)), Rig(), 1, history, images=False)
    errors = []
    for cycle in range(60_000):
        now = 0.001 * cycle
        history.append(now, 0.00625 * float(np.sin(W * now)), 0.0)
        for delivery in camera.due(now):
            exact = -5.0 * np.sin(W * delivery.truth.mid_exposure_s) * np.sinc(2.6 * 0.015)
            errors.append(camera.tracked_displacement(delivery.truth.frame) - exact)
    assert len(errors) > 3800
    assert np.std(errors) == pytest.approx(0.05, rel=0.05)
    assert abs(np.mean(errors)) < 0.003
    assert abs(np.corrcoef(errors[1:], errors[:-1])[0, 1]) < 0.05
    with pytest.raises(KeyError):
        camera.tracked_displacement(3)  # long past
    with pytest.raises(KeyError):
        camera.tracked_displacement(10**6)


def test_who_asks_too_seldom_gets_the_newest_frames() -> None:
    rig = Rig(scene=SimulatedScene(buffers=3))
    history = PoseHistory(None)
    camera = VirtualCamera(Model(), rig, 1, history, images=False)
    for cycle in range(1000):
        history.append(0.001 * cycle, 0.0, 0.0)
    delivered = camera.due(0.999)
    frames = [d.truth.frame for d in delivered]
    assert len(frames) == 3
    assert frames == list(range(camera.lost, camera.lost + 3))
    assert camera.lost > 50


def test_a_triggered_camera_delivers_what_was_requested() -> None:
    history = PoseHistory(None)
    camera = VirtualCamera(Model(camera=Camera(mode="triggered")), Rig(), 1, history, images=False)
    requests = [0.1, 0.25, 0.5]
    mids = []
    for cycle in range(1000):
        now = 0.001 * cycle
        history.append(now, 0.0, 0.0)
        if requests and now >= requests[0]:
            camera.request(requests.pop(0))
        mids += [d.truth.mid_exposure_s for d in camera.due(now)]
    assert mids == pytest.approx([0.1075, 0.2575, 0.5075])
