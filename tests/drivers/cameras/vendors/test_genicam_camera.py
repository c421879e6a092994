"""The GenICam backend against the package's own test transport layer."""

import importlib.util
from pathlib import Path

import pytest

from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera_factory import open_camera
from tests.fixtures.vendor_cameras import frames_of


def test_harvesters_with_the_test_transport_layer():
    spec = importlib.util.find_spec("genicam")
    if spec is None or importlib.util.find_spec("harvesters") is None:
        pytest.skip("harvesters is not installed")
    producer = Path(spec.origin).parent / "viky.cti"
    if not producer.exists():
        pytest.skip("this genicam brings no test transport layer")
    camera = open_camera(CameraDevice(driver="genicam", producer=str(producer), frame_rate_hz=15.0))
    frames = frames_of(camera, 4)
    assert frames[0].image.ndim == 2 and frames[0].stamp_s is None  # it gives none
    assert [f.counter - frames[0].counter for f in frames] == [0, 1, 2, 3]
    assert camera.notes == []
    with pytest.raises(UserError, match=r"^camera\.producer = '/nowhere\.cti': no such file"):
        open_camera(CameraDevice(driver="genicam", producer="/nowhere.cti")).start()
