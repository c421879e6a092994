"""libcamera's backend against a fake of picamera2."""

import sys
import types
from typing import ClassVar

import numpy as np
import pytest

from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera_factory import open_camera


def fake_picamera2(monkeypatch, frames):
    """A module picamera2 with one camera that has these frames ready: their metadata, or an exception."""

    class Picamera2:
        given: ClassVar = list(frames)
        controls: ClassVar = {}
        closed = 0

        @staticmethod
        def global_camera_info():
            return [{"Model": "imx296"}]

        def __init__(self, number):
            self.number = number

        def create_video_configuration(self, main, controls, buffer_count, queue):
            Picamera2.controls = controls
            return {"main": {"size": (64, 48)}}

        def configure(self, configuration):
            self.configuration = configuration

        def camera_configuration(self):
            return self.configuration

        def start(self):
            pass

        stop = start

        def close(self):
            Picamera2.closed += 1

        def capture_request(self, wait):
            if not self.given:
                raise TimeoutError
            given = self.given.pop(0)
            if isinstance(given, Exception):
                raise given
            return types.SimpleNamespace(
                get_metadata=lambda: given,
                make_array=lambda name: np.full((72, 64), 5, np.uint8),
                release=lambda: None,
            )

    module = types.ModuleType("picamera2")
    module.Picamera2 = Picamera2
    monkeypatch.setitem(sys.modules, "picamera2", module)
    return Picamera2


def test_libcamera_against_a_fake_of_picamera2(monkeypatch):
    metadata = {"SensorTimestamp": 5 * 10**9, "ExposureTime": 8000}
    fake = fake_picamera2(monkeypatch, [metadata, {}, RuntimeError("camera gone")])
    config = CameraDevice(driver="libcamera", exposure_s=0.008, frame_rate_hz=60.0, gain=2.0)
    camera = open_camera(config)
    camera.start()
    assert fake.controls == {
        "AeEnable": False,
        "ExposureTime": 8000,
        "AnalogueGain": 2.0,
        "FrameDurationLimits": (16667, 16667),
    }
    first, second, third = (camera.read(0.1) for _ in range(3))
    assert first.image.shape == (48, 64) and first.stamp_s == pytest.approx(5.004)
    assert first.counter is None and first.exposure_s == pytest.approx(0.008)
    assert second.stamp_s is None and second.exposure_s is None
    assert third is None and fake.closed == 1


@pytest.mark.parametrize(
    ("config", "words"),
    [
        (
            CameraDevice(driver="libcamera", device="3"),
            r"camera\.device = '3': no such camera \(found: imx296\)",
        ),
        (
            CameraDevice(driver="libcamera", trigger="line"),
            r"camera\.trigger = 'line': libcamera has no trigger",
        ),
        (
            CameraDevice(driver="libcamera", width_px=800, height_px=600),
            r"camera\.width_px = 800: [^\n]*64x48",
        ),
    ],
)
def test_what_libcamera_does_not_have(monkeypatch, config, words):
    fake_picamera2(monkeypatch, [])
    with pytest.raises(UserError, match=words):
        open_camera(config).start()
