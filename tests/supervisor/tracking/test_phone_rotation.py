"""Image rotation of a hand-held phone against its rotation sensor: a real capture delay. See docs/tracking.md.

The camera moves as well as turns, half a metre from a laptop, so dx and dy hold parallax; the rotation about the
optical axis does not.
"""

from pathlib import Path

import numpy as np
import pytest

from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.common.files.configuration import Tracker
from stillarm.drivers.cameras.camera import EndOfStream
from stillarm.drivers.cameras.file_camera import FileCamera
from stillarm.supervisor.tracking.tracker import FeatureTracker

FOLDER = Path(__file__).parents[4] / "shared" / "data" / "phone_rotation"
RATE_HZ = 15.0
pytestmark = [
    pytest.mark.hardware_data,
    pytest.mark.skipif(not FOLDER.is_dir(), reason="needs ../shared/data/phone_rotation"),
]


def image_rates():
    """dx, dy (px/s) and rotation (rad/s) between frames, (n - 1, 3); NaN where either was not measured.

    A hand-held camera leaves the tracker's one rigid displacement again and again: then a new origin is taken.
    """
    camera, tracker, poses, rates = FileCamera(next(FOLDER.glob("*.mp4"))), FeatureTracker(Tracker()), [], []
    camera.start()
    try:
        while True:
            image = camera.read(0.0).image
            found = tracker.track(image)
            if found.status != TrackingStatus.MEASURED:
                tracker.restart()
                tracker.track(image)
                rates.append(np.full(3, np.nan))
                poses.append(np.zeros(3))
                continue
            poses.append(np.array([found.dx, found.dy, found.rotation]))
            rates.append((poses[-1] - poses[-2]) * RATE_HZ if len(poses) > 1 else np.full(3, np.nan))
    except EndOfStream:
        camera.close()
    return np.array(rates[1:])


def sensor_angles():
    """Times since the recording began, s, (n,), and the integrated rates about the phone's axes, rad, (n, 3)."""
    lines = (
        next(FOLDER.glob("*.txt")).read_text().replace("[", "").replace("]", "").replace(",", " ").split("\n")
    )
    rows = np.array([[float(v) for v in line.split()] for line in lines[2:] if line.strip()])
    t = 1e-9 * rows[:, 1]
    t += np.median(1e-3 * rows[:, 0] - t) - 1e-3 * float(lines[0])
    turns = rows[:, 2:].reshape(-1, 3, 3)
    step = np.einsum("kji,kjl->kil", turns[:-1], turns[1:])
    axes = ((2, 1), (0, 2), (1, 0))
    small = np.stack([0.5 * (step[:, i, j] - step[:, j, i]) for i, j in axes], axis=1)
    return t, np.concatenate([np.zeros((1, 3)), np.cumsum(small, axis=0)])


def best_lag(image, angles, t):
    """Correlation of the image's rate with that of the best combination of the axes, and the lag in s."""
    frames, best = np.arange(len(image) + 1) / RATE_HZ, (0.0, 0.0)
    good = np.isfinite(image)
    for lag in np.arange(-0.8, 0.8, 0.01):
        sensor = [np.diff(np.interp(frames + lag, t, angles[:, axis]))[good] for axis in range(3)]
        design = np.stack([*sensor, np.ones(good.sum())], axis=1)
        model = design @ np.linalg.lstsq(design, image[good], rcond=None)[0]
        best = max(best, (float(np.corrcoef(model, image[good])[0, 1]), float(lag)))
    return best


@pytest.mark.slow
def test_the_image_turns_as_the_sensor_says_after_one_constant_lag():
    rates, (t, angles) = image_rates(), sensor_angles()
    assert np.isfinite(rates[:, 2]).mean() > 0.55
    correlation, lag = best_lag(rates[:, 2], angles, t)
    assert correlation > 0.9
    assert abs(lag - 0.47) < 0.03
    for axis in (0, 1):
        correlation, lag = best_lag(rates[:, axis], angles, t)
        assert correlation > 0.7
        assert abs(lag - 0.47) < 0.03
