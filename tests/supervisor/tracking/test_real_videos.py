"""The tracker on measured videos, against the references that came with them. See docs/tracking.md."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from stillarm.common.files.configuration import Tracker
from stillarm.drivers.cameras.camera import EndOfStream
from stillarm.drivers.cameras.file_camera import FileCamera
from stillarm.supervisor.tracking.tracker import FeatureTracker

DATA = Path(__file__).parents[4] / "shared" / "data"
pytestmark = [
    pytest.mark.hardware_data,
    pytest.mark.skipif(not DATA.is_dir(), reason="needs ../shared/data, the measured videos"),
]


def played(path, frames=10**9, crop=np.s_[:, :]):
    """status, dx, dy of each frame, shape (n, 3)."""
    camera, tracker, rows = FileCamera(path), FeatureTracker(Tracker()), []
    camera.start()
    try:
        while len(rows) < frames:
            result = tracker.track(np.ascontiguousarray(camera.read(0.0).image[crop]))
            rows.append((result.status, result.dx, result.dy))
    except EndOfStream:
        pass
    camera.close()
    return np.array(rows, dtype=float)


def test_synthetic_beam_video_against_its_truth():
    rows = played(DATA / "beam_video" / "data_synthetic.cih")
    truth = np.load(DATA / "beam_video" / "data_synthetic_generated.npy")[1:].T
    truth = truth - truth[0]
    assert (rows[:, 0] == 0).all() and len(rows) == len(truth)
    assert np.sqrt(np.mean((rows[:, 1:] - truth) ** 2)) < 0.003
    for axis in (0, 1):
        assert abs(np.polyfit(truth[:, axis], rows[:, 1 + axis], 1)[0] - 1.0) < 0.03


@pytest.mark.slow
def test_speckled_beam():
    right_third = np.s_[:, 660:]  # the beam bends; of the thirds, the one that gives the published figure
    rows = played(DATA / "beam_video" / "Speckle_beam_500.cih", crop=right_third)
    assert (rows[:, 0] == 0).all() and len(rows) == 500
    assert np.ptp(rows[:, 1]) < 0.1  # it vibrates vertically
    assert abs(np.ptp(rows[:, 2]) - 0.76) < 0.04


@pytest.mark.slow
def test_tuning_fork_rings_at_its_drive():
    one_tine = np.s_[60:420, 290:342]
    rows = played(DATA / "tuning_fork_video" / "tuning_hz32_fps250_50-1_640x420.mp4", 300, one_tine)
    assert (rows[:, 0] == 0).mean() > 0.95
    good = rows[:, 0] == 0
    time, x = np.flatnonzero(good) / 250.0, rows[good, 1] - rows[good, 1].mean()
    frequency = np.arange(20.0, 45.0, 0.02)
    spectrum = np.abs(np.exp(-2j * np.pi * np.outer(frequency, time)) @ x)
    assert abs(frequency[spectrum.argmax()] - 32.0) < 0.15


def test_a_video_40_px_high_against_the_whole_image_s_motion():
    path = DATA / "beam_video" / "data_showcase.cih"
    rows = played(path)
    assert (rows[:, 0] == 0).all() and len(rows) == 75
    camera, first, whole = FileCamera(path), None, []
    warp = np.eye(2, 3, dtype=np.float32)
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-5)
    camera.start()
    for _ in rows:
        image = camera.read(0.0).image
        first = image if first is None else first
        _, warp = cv2.findTransformECC(first, image, warp, cv2.MOTION_TRANSLATION, criteria)
        whole.append(warp[:, 2].copy())
    camera.close()
    assert (
        np.sqrt(np.mean((rows[:, 1:] - np.array(whole)) ** 2)) < 0.06
    )  # the beams bend: no one displacement
