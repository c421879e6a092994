"""The live camera, with a capture that obeys, refuses, stalls, lies about its stamps, or goes away."""

from itertools import pairwise

import cv2
import numpy as np
import pytest

from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.opencv_camera import REOPEN_S, OpenCvCamera, set_capture


class FakeCapture:
    """The part of cv2.VideoCapture that the driver uses, on a clock of its own."""

    def __init__(self, clock, opened=True, size=(640, 480), fixed=False):
        self.clock, self.opened, self.fixed = clock, opened, fixed
        self.properties = {cv2.CAP_PROP_FRAME_WIDTH: size[0], cv2.CAP_PROP_FRAME_HEIGHT: size[1]}
        self.images = []
        self.backend = "V4L2"
        self.stamp_s = None
        self.released = 0

    def isOpened(self):
        return self.opened

    def set(self, prop, value):
        if not self.fixed:
            self.properties[prop] = value
        return not self.fixed

    def get(self, prop):
        if prop == cv2.CAP_PROP_POS_MSEC:
            return 1000.0 * (self.clock.now - 0.02 if self.stamp_s is None else self.stamp_s)
        return self.properties.get(prop, 0.0)

    def read(self):
        self.clock.now += 0.015
        return (True, self.images.pop(0)) if self.images else (False, None)

    def getBackendName(self):
        return self.backend

    def release(self):
        self.released += 1


class Clock:
    """A clock that moves when told to."""

    now = 100.0

    def __call__(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds


def camera_with(capture, clock, **size):
    return OpenCvCamera("0", **size, opener=lambda _: capture, clock=clock, sleep=clock.sleep)


def test_sets_and_reads_back_size_and_buffer():
    clock = Clock()
    capture = FakeCapture(clock)
    camera = camera_with(capture, clock, width_px=320, height_px=240)
    camera.start()
    assert capture.properties[cv2.CAP_PROP_FRAME_WIDTH] == 320 and camera.buffer_frames == 1.0
    camera.close()
    camera.close()
    assert capture.released == 1


def test_a_size_that_the_camera_does_not_take_is_named():
    clock = Clock()
    capture = FakeCapture(clock, fixed=True)
    with pytest.raises(UserError, match=r"camera.width_px = 800: camera '0' gives 640") as error:
        camera_with(capture, clock, width_px=800).start()
    assert "\n" not in str(error.value) and capture.released == 1


def test_a_device_that_is_not_there_is_named():
    clock = Clock()
    with pytest.raises(UserError, match=r"camera\.device = '0'") as error:
        camera_with(FakeCapture(clock, opened=False), clock).start()
    assert "\n" not in str(error.value)


def test_frames_are_grey_and_stamped_when_plausible():
    clock = Clock()
    capture = FakeCapture(clock)
    capture.images = [np.full((48, 64, 3), 77, np.uint8), np.full((48, 64), 78, np.uint8)]
    camera = camera_with(capture, clock)
    camera.start()
    frame = camera.read(0.1)
    assert frame.image.shape == (48, 64) and frame.image[0, 0] == 77 and frame.counter is None
    assert frame.stamp_s == pytest.approx(clock.now - 0.02)
    capture.stamp_s = 0.0
    assert camera.read(0.1).stamp_s is None


def test_a_stalled_device_gives_none_and_is_opened_again():
    clock = Clock()
    captures = [FakeCapture(clock), FakeCapture(clock, opened=False), FakeCapture(clock)]
    captures[2].images = [np.zeros((48, 64), np.uint8)]
    first, opened = captures[0], []

    def opener(_device):
        opened.append(clock.now)
        return captures.pop(0)

    camera = OpenCvCamera("0", opener=opener, clock=clock, sleep=clock.sleep)
    camera.start()
    frames = []
    while clock.now < 100.0 + 3 * REOPEN_S:
        frames.append(camera.read(0.1))
    assert frames[0] is None and camera.failed_reads > 10
    assert first.released == 1
    assert len(opened) == 3 and all(b - a >= REOPEN_S for a, b in pairwise(opened))
    assert sum(f is not None for f in frames) == 1


def test_exposure_gain_rate_and_buffers_are_set_and_read_back():
    clock = Clock()
    capture = FakeCapture(clock)
    config = CameraDevice(exposure_s=0.005, gain=3.0, frame_rate_hz=60.0, buffers=2)
    notes, exposure_s = set_capture(capture, config)
    assert notes == [] and exposure_s == pytest.approx(0.005)
    assert capture.properties[cv2.CAP_PROP_EXPOSURE] == 50  # V4L2 counts in 100 us
    assert capture.properties[cv2.CAP_PROP_AUTO_EXPOSURE] == 1  # manual
    assert capture.properties[cv2.CAP_PROP_FPS] == 60.0
    assert capture.properties[cv2.CAP_PROP_BUFFERSIZE] == 2


def test_what_a_webcam_refuses_is_told_in_one_line_each():
    capture = FakeCapture(Clock(), fixed=True)
    notes, exposure_s = set_capture(capture, CameraDevice(exposure_s=0.005, gain=3.0, frame_rate_hz=60.0))
    assert [note.split(" = ")[0] for note in notes] == [
        "camera.exposure_s",
        "camera.gain",
        "camera.frame_rate_hz",
    ]
    assert all("instead" in note and "\n" not in note for note in notes) and exposure_s is None


def test_a_backend_that_does_not_say_what_its_exposure_means_is_not_believed():
    capture = FakeCapture(Clock())
    capture.backend = "FFMPEG"
    (note,), exposure_s = set_capture(capture, CameraDevice(exposure_s=0.005))
    assert "FFMPEG does not define the unit of its exposure" in note and exposure_s is None


def test_a_stamp_is_brought_from_the_start_of_exposure_to_its_middle():
    clock = Clock()
    capture = FakeCapture(clock)
    capture.images = [np.full((48, 64), 77, np.uint8)]
    config = CameraDevice(exposure_s=0.010)
    camera = OpenCvCamera("0", config=config, opener=lambda _: capture, clock=clock, sleep=clock.sleep)
    camera.start()
    frame = camera.read(0.1)
    assert frame.exposure_s == pytest.approx(0.010)
    assert frame.stamp_s == pytest.approx(clock.now - 0.02 + 0.005)
