"""The timing's causes, frame by frame, against the catalogue's rules; the other chances stay as they were."""

from typing import Any

from stillarm.common.files.configuration import Rig, SimulatedScene
from stillarm.common.files.model import Camera, Timing
from stillarm.simulation.camera.camera_timing import CameraTiming
from tests.fixtures.exposures import ORIGIN_S, exposures


def test_no_size_no_effect_to_the_bit() -> None:
    none: list[dict[str, Any]] = [
        {"cause": "camera_clock_skew", "skew_ppm": 0.0},
        {"cause": "frame_drops", "fraction": 0.0},
        {"cause": "delay_bursts", "rate_hz": 0.0, "duration_s": 0.1, "delay_s": 0.1},
        {"cause": "delay_drift", "rate_s_per_s": 0.0},
        {"cause": "stale_frame_buffer", "onset_s": 1.0, "frames": 0},
        {"cause": "clock_step", "onset_s": 1.0, "step_s": 0.0, "clock": "camera"},
    ]
    bare = CameraTiming(Camera(), Timing(), Rig(scene=SimulatedScene(stamped=True)), 3, origin_s=ORIGIN_S)
    assert exposures(*none, stamped=True) == [bare.expose() for _ in range(2000)]
