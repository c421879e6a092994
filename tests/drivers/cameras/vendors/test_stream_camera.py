"""What every vendor's camera has in common, on a backend that fails in every way."""

import numpy as np
import pytest

from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera_stamps import DeviceStampGate, StampReference, mid_exposure_s
from stillarm.drivers.cameras.vendors.stream_camera import REOPEN_S, BackendLost, Grab, StreamCamera

IMAGE = np.full((48, 64), 7, np.uint8)


class Backend:
    """Gives what it is told to give, in order; then nothing."""

    def __init__(self, clock, given, reference=StampReference.EXPOSURE_START, modulus=0):
        self.clock, self.given = clock, list(given)
        self.reference, self.counter_modulus = reference, modulus
        self.opened = self.closed = self.triggered = 0
        self.present = True

    def open(self):
        self.opened += 1
        if not self.present:
            raise UserError("away")
        return ["camera.gain = 3: the camera took 2 instead"]

    def grab(self, timeout_s):
        self.clock.now += 0.02
        if not self.present:
            raise BackendLost
        return self.given.pop(0) if self.given else None

    def trigger(self):
        self.triggered += 1

    def close(self):
        self.closed += 1


class Clock:
    now = 10.0

    def __call__(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds


def camera_of(given, config=None, **kinds):
    clock = Clock()
    backend = Backend(clock, given, **kinds)
    camera = StreamCamera(backend, config or CameraDevice(driver="basler"), clock=clock, sleep=clock.sleep)
    camera.start()
    return camera, backend, clock


@pytest.mark.parametrize(
    ("reference", "mid"),
    [("exposure_start", 5.005), ("mid_exposure", 5.0), ("exposure_end", 4.995), ("transfer_end", 4.995)],
)
def test_stamps_become_mid_exposure_as_the_backend_or_the_configuration_says(reference, mid):
    grab = Grab(IMAGE, 1, 5.0, 0.010)
    assert camera_of([grab], reference=StampReference(reference))[0].read(0.1).stamp_s == pytest.approx(mid)
    told = CameraDevice(driver="basler", stamp_reference=reference)
    assert camera_of([grab], told)[0].read(0.1).stamp_s == pytest.approx(mid)


def test_an_unknown_exposure_leaves_the_stamp_as_it_is():
    assert mid_exposure_s(5.0, StampReference.EXPOSURE_START, None) == 5.0


@pytest.mark.parametrize("stamp", [None, 0.0, float("nan"), -1.0])
def test_what_is_no_stamp_is_absent(stamp):
    frame = camera_of([Grab(IMAGE, 1, stamp, 0.01)])[0].read(0.1)
    assert frame.stamp_s is None and frame.counter == 1 and frame.exposure_s == 0.01


def test_a_stamp_that_does_not_rise_is_absent():
    gate = DeviceStampGate()
    assert [gate.accept(s) for s in (1.0, 1.0, 0.5, 0.6)] == [1.0, None, None, 0.6]


def test_images_with_holes_or_of_another_size_are_left_out_and_counted():
    given = [Grab(IMAGE, 1), Grab(IMAGE, 2, whole=False), Grab(IMAGE[:10], 3), Grab(None, 4), Grab(IMAGE, 5)]
    camera, _, _ = camera_of(given)
    frames = [camera.read(0.1) for _ in given]
    assert [f and f.counter for f in frames] == [1, None, None, None, 5] and camera.incomplete == 3


def test_wrong_counters_never_run_backwards():
    raw = [5, 6, 6, 2, 3, 4, 10**9, 7]
    camera, _, _ = camera_of([Grab(IMAGE, count) for count in raw])
    counts = [camera.read(0.1).counter for _ in raw]
    assert counts == [5, 6, 7, 8, 9, 10, 11, 12] and camera.wrong_counters == 4


def test_unplugged_and_plugged_again():
    camera, backend, clock = camera_of([Grab(IMAGE, 1)])
    assert camera.read(0.1).counter == 1
    backend.present = False
    until = clock.now + 5.0
    while clock.now < until:
        assert camera.read(0.1) is None
    assert camera.reopened >= 2 and backend.closed == 1
    backend.present, backend.given = True, [Grab(IMAGE, 0)]  # its counter starts anew
    frames = [camera.read(0.1) for _ in range(60)]
    assert [f.counter for f in frames if f] == [2]


def test_a_camera_that_gives_nothing_is_opened_again():
    camera, backend, clock = camera_of([])
    while clock.now < 10.0 + 3 * REOPEN_S:
        camera.read(0.1)
    assert backend.opened >= 2 and backend.closed >= 1


def test_a_software_trigger_keeps_as_many_under_way_as_asked_for():
    clock = Clock()
    backend = Backend(clock, [Grab(IMAGE, 1), Grab(IMAGE, 2, whole=False), None])
    config = CameraDevice(driver="basler", trigger="software")
    camera = StreamCamera(backend, config, in_flight=3, clock=clock, sleep=clock.sleep)
    camera.start()
    assert backend.triggered == 3
    for _ in range(3):
        camera.read(0.1)
    assert backend.triggered == 6  # and once more for the image that did not come


def test_what_the_camera_refused_is_told():
    assert camera_of([])[0].notes == ["camera.gain = 3: the camera took 2 instead"]
