"""Pylon's emulated camera streams into the supervisor, as a process of its own, which counts every exposure."""

import importlib.util
import os
import signal
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path

import pytest

from stillarm.common.recording.reader import open_recording

ROOT = Path(__file__).parents[2]
CONFIG = """
[link]
controller_port = 47931
supervisor_port = 47932
[camera]
driver = "basler"
width_px = 640
height_px = 480
exposure_s = 0.005
frame_rate_hz = 65.0
[telemetry]
enabled = false
"""


@pytest.mark.realtime
def test_pylon_s_emulator_streams_into_the_supervisor(tmp_path: Path) -> None:
    if importlib.util.find_spec("pypylon") is None:
        pytest.skip("pypylon is not installed")
    (tmp_path / "model.toml").write_text((ROOT / "configs" / "model.toml").read_text())
    config, images = tmp_path / "config.toml", tmp_path / "images.mcap"
    config.write_text(CONFIG)
    supervisor = subprocess.Popen(
        [
            sys.executable,
            "-P",
            "-m",
            "stillarm",
            "supervisor",
            "--config",
            str(config),
            "--record-images",
            str(images),
        ],
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYLON_CAMEMU": "1"},
        stdout=subprocess.PIPE,
        text=True,
    )
    time.sleep(6.0)
    supervisor.send_signal(signal.SIGTERM)
    said, _ = supervisor.communicate(timeout=30)
    assert supervisor.returncode == 0 and " frames" in said
    taken = list(open_recording(images).messages("/images"))
    assert len(taken) > 20
    counts = [image.counter for image in taken]
    assert all(after > before for before, after in pairwise(counts))
    times = [image.time_s for image in taken]
    print(f"{(counts[-1] - counts[0]) / (times[-1] - times[0]):.1f} exposures a second")
