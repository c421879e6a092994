"""Aravis's backend against its fake camera."""

import importlib.util
import sys
from itertools import pairwise
from pathlib import Path

import pytest

from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera_factory import open_camera
from tests.fixtures.vendor_cameras import frames_of

DIST_PACKAGES = "/usr/lib/python3/dist-packages"


@pytest.fixture
def aravis(monkeypatch):
    """Debian's python3-gi, where its Python is this one's version."""
    if importlib.util.find_spec("gi") is None:
        if not list(Path(DIST_PACKAGES).glob(f"gi/_gi.cpython-3{sys.version_info[1]}*")):
            pytest.skip("python3-gi is not installed for this Python")
        monkeypatch.setattr(sys, "path", [*sys.path, DIST_PACKAGES])
    gi = pytest.importorskip("gi")
    try:
        gi.require_version("Aravis", "0.8")
    except ValueError:
        pytest.skip("gir1.2-aravis-0.8 is not installed")


def test_aravis_s_fake_camera_streams_with_counters_and_stamps(aravis):
    config = CameraDevice(driver="aravis", device="Fake_1", exposure_s=0.004, frame_rate_hz=50.0)
    camera = open_camera(config)
    frames = frames_of(camera, 10)
    assert camera.notes == [] and frames[0].image.shape == (512, 512)
    assert frames[0].exposure_s == pytest.approx(0.004)
    assert all(after.counter > before.counter for before, after in pairwise(frames))
    assert all(after.stamp_s > before.stamp_s for before, after in pairwise(frames))
    with pytest.raises(UserError, match=r"camera\.device = 'Nobody': no such camera \(found: "):
        open_camera(CameraDevice(driver="aravis", device="Nobody")).start()
