"""Features of a GenICam camera: set, read back, refused in one line."""

import pytest

from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.vendors.camera_features import set_features
from stillarm.drivers.cameras.vendors.stream_camera import chosen


@pytest.mark.parametrize(("device", "place"), [("B2", 1), ("0", 0), ("2", None), ("C", None)])
def test_a_camera_is_chosen_by_serial_number_or_place(device, place):
    assert chosen(CameraDevice(device=device), ["A1", "B2"]) == place


class Features:
    """A camera with some features, each of which takes values within bounds."""

    def __init__(self, **bounds):
        self.bounds = bounds
        self.values = {name: bound[0] for name, bound in bounds.items()}

    def write(self, name, value):
        if name not in self.bounds:
            return False
        allowed = self.bounds[name]
        self.values[name] = (
            value if isinstance(value, bool | str) else min(max(value, allowed[0]), allowed[-1])
        )
        return True

    def number(self, name):
        value = self.values.get(name)
        return None if value is None or isinstance(value, str) else float(value)


PLAIN = {"Width": (64, 640), "Height": (64, 480), "PixelFormat": ("", "z")}


def test_features_are_set_and_read_back():
    features = Features(**PLAIN, ExposureTime=(100, 20000), AcquisitionFrameRate=(1, 60), Gain=(0, 20))
    config = CameraDevice(width_px=320, height_px=240, exposure_s=0.005, frame_rate_hz=50.0, gain=6.0)
    assert set_features(features, config) == []
    assert features.values["AcquisitionFrameRate"] == pytest.approx(50.0)
    assert features.values["ExposureTime"] == pytest.approx(5000) and features.values["Width"] == 320


def test_features_by_their_older_names():
    features = Features(**PLAIN, ExposureTimeAbs=(100, 20000), AcquisitionFrameRateAbs=(1, 60))
    assert set_features(features, CameraDevice(exposure_s=0.005, frame_rate_hz=50.0)) == []
    assert features.values["ExposureTimeAbs"] == pytest.approx(5000)


@pytest.mark.parametrize(
    ("config", "words"),
    [
        (CameraDevice(exposure_s=0.5), "camera.exposure_s = 0.5: the camera took 0.02 instead"),
        (CameraDevice(frame_rate_hz=500.0), "camera.frame_rate_hz = 500: the camera took 60 instead"),
        (CameraDevice(gain=3.0), "camera.gain = 3: the camera has no such setting"),
    ],
)
def test_what_is_refused_is_one_line(config, words):
    features = Features(**PLAIN, ExposureTime=(100, 20000), AcquisitionFrameRate=(1, 60))
    (note,) = set_features(features, config)
    assert words in note and "\n" not in note


def test_a_size_that_is_not_taken_stops():
    with pytest.raises(UserError, match=r"camera\.width_px = 800: camera '0' gives 640 instead"):
        set_features(Features(**PLAIN), CameraDevice(width_px=800))


def test_a_trigger_that_is_not_there_stops():
    with pytest.raises(UserError, match=r"camera\.trigger = 'software'"):
        set_features(Features(**PLAIN), CameraDevice(trigger="software"))
