"""The image's causes: what the tracker's stand-in and the rendered, truly tracked image show of them."""

from typing import Any

import numpy as np
import pytest

from stillarm.common.files.configuration import Rig, SimulatedScene, Tracker
from stillarm.common.files.model import Camera, Model
from stillarm.simulation.camera.pose_history import PoseHistory
from stillarm.simulation.camera.virtual_camera import VirtualCamera
from stillarm.supervisor.step import Supervisor

LENS = {"cause": "lens_distortion", "coefficient_per_px2": 4e-5}
DRIFT = {"cause": "tracking_drift", "rate_px_per_s": 3.0}
TILT = {"cause": "camera_tilt_coupling", "rotation_px_per_rad": -200.0}


def seen(
    *effects: dict[str, Any], images: bool = False, still: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Mid-exposures and displacements over a second of slow motion (or of rest), relative to the first when tracked."""
    model = Model(camera=Camera(noise_std_px=0.0), effects=list(effects))
    history, rig = PoseHistory(None), Rig(scene=SimulatedScene(width_px=320, height_px=240))
    camera = VirtualCamera(model, rig, 2, history, images=images)
    tracker = Supervisor(Tracker()) if images else None
    mids, found = [], []
    for cycle in range(1100):
        now = 0.001 * cycle
        history.append(now, 0.0 if still else position(now), 0.0 if still else angle(now))
        for delivery in camera.due(now):
            mids.append(delivery.truth.mid_exposure_s)
            if tracker is None:
                found.append(camera.tracked_displacement(delivery.truth.frame))
            else:
                found.append(tracker.step(delivery.as_frame(), 0).displacement_x_px)
    return np.array(mids), np.array(found)


def position(time: Any) -> Any:
    return 0.05 * np.sin(2.0 * np.pi * 0.5 * time)


def angle(time: Any) -> Any:
    return 0.03 * np.sin(2.0 * np.pi * 0.7 * time)


def test_each_is_what_the_catalogue_says() -> None:
    """Of a slow motion, whose mean over 15 ms is that at mid-exposure within 1e-3 of a pixel."""
    mids, plain = seen()
    d = -800.0 * position(mids)
    assert plain == pytest.approx(d, abs=0.01)
    assert seen(LENS)[1] == pytest.approx(d * (1.0 + 4e-5 * d * d), abs=0.01)
    assert np.max(np.abs(4e-5 * d**3)) > 2.0
    assert seen(DRIFT)[1] == pytest.approx(d + 3.0 * mids, abs=0.01)
    assert seen(TILT)[1] == pytest.approx(d + 200.0 * angle(mids), abs=0.01)
    assert seen(LENS, DRIFT)[1] == pytest.approx(d * (1.0 + 4e-5 * d * d) + 3.0 * mids, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("effects", [(LENS,), (DRIFT,), (TILT,)])
def test_rendered_and_tracked_images_show_the_same(effects: tuple[dict[str, Any], ...]) -> None:
    """Within a twentieth of a pixel, as without effects."""
    _, stand_in = seen(*effects)
    _, tracked = seen(*effects, images=True)
    assert len(tracked) > 50
    assert tracked - tracked[0] == pytest.approx(stand_in - stand_in[0], abs=0.05)


def test_no_size_no_effect_to_the_bit() -> None:
    none = ({**LENS, "coefficient_per_px2": 0.0}, {**DRIFT, "rate_px_per_s": 0.0})
    assert np.array_equal(seen(*none)[1], seen()[1])
    assert np.array_equal(seen(LENS, still=True)[1], np.zeros(len(seen(still=True)[1])))
