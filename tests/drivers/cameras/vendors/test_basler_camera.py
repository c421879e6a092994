"""Basler's backend against pylon's camera emulator."""

import importlib.util
from itertools import pairwise

import numpy as np
import pytest

from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera_factory import open_camera
from tests.fixtures.vendor_cameras import frames_of


@pytest.fixture
def emulated_pylon(monkeypatch):
    if importlib.util.find_spec("pypylon") is None:
        pytest.skip("pypylon is not installed")
    monkeypatch.setenv("PYLON_CAMEMU", "1")


def test_basler_s_emulator_streams_with_counters_and_without_stamps(emulated_pylon):
    camera = open_camera(
        CameraDevice(driver="basler", width_px=640, height_px=480, exposure_s=0.005, frame_rate_hz=50.0)
    )
    frames = frames_of(camera, 20)
    assert camera.notes == [] and camera.wrong_counters == 0
    assert frames[0].image.shape == (480, 640) and frames[0].image.dtype == np.uint8
    assert all(after.counter > before.counter for before, after in pairwise(frames))
    assert frames[0].exposure_s == pytest.approx(0.005)
    assert all(frame.stamp_s is None for frame in frames)  # the emulator's are 0


def test_basler_s_emulator_says_what_it_does_not_take(emulated_pylon):
    with pytest.raises(UserError, match=r"camera\.width_px = 9000: camera '0' gives \d+ instead"):
        open_camera(CameraDevice(driver="basler", width_px=9000)).start()
    with pytest.raises(UserError, match=r"camera\.device = '7': no such camera \(found: 0815-0000\)"):
        open_camera(CameraDevice(driver="basler", device="7")).start()


def test_basler_s_emulator_triggered_by_software(emulated_pylon):
    camera = open_camera(CameraDevice(driver="basler", width_px=64, height_px=64, trigger="software"), 2)
    frames = frames_of(camera, 5)
    assert all(after.counter > before.counter for before, after in pairwise(frames))
