"""The supervisor's start: frames queued in the camera are discarded, and the next frame is fresh."""

from collections import deque

import numpy as np
import pytest

from stillarm.drivers.cameras.camera import EndOfStream, Frame
from stillarm.supervisor.start_up import discard_queued, warm_up_recording

PERIOD_S = 1.0 / 65.0
IMAGE = np.zeros((4, 4), np.uint8)


class QueuedCamera:
    """A camera whose driver holds frames already; then one comes each period. Time passes in read() only."""

    def __init__(self, queued: int, period_s: float = PERIOD_S, stalled: bool = False) -> None:
        self.notes: list[str] = []
        self.now_s = 100.0
        self.stalled = stalled
        self._period_s = period_s
        self._queue = deque(range(queued))
        self._next = queued

    def start(self) -> None:
        """Nothing to open."""

    def read(self, timeout_s: float) -> Frame | None:
        if self._queue:
            self.now_s += 20e-6
            return Frame(IMAGE, self._queue.popleft(), None, None)
        if self.stalled:
            self.now_s += timeout_s
            return None
        self.now_s += self._period_s
        self._next += 1
        return Frame(IMAGE, self._next - 1, None, None)

    def close(self) -> None:
        """Nothing to close."""

    def clock(self) -> float:
        return self.now_s


@pytest.mark.parametrize("queued", [0, 1, 8, 40])
def test_the_first_frame_after_it_is_one_that_had_to_be_waited_for(queued: int) -> None:
    """For any number of queued frames; the check costs one fresh frame."""
    camera = QueuedCamera(queued)
    assert discard_queued(camera, camera.clock) == queued + 1
    asked = camera.now_s
    frame = camera.read(0.1)
    assert frame is not None and frame.counter == queued + 1
    assert camera.now_s - asked == pytest.approx(PERIOD_S)


def test_a_camera_that_gives_nothing_is_waited_for_once() -> None:
    """The loop says that there is no image; the start does not hang on it."""
    camera = QueuedCamera(3, stalled=True)
    assert discard_queued(camera, camera.clock) == 3
    assert camera.now_s < 100.2


def test_a_camera_that_is_always_ready_does_not_hold_up_the_start() -> None:
    camera = QueuedCamera(0, period_s=1e-4)
    assert discard_queued(camera, camera.clock) == 64


def test_the_end_of_a_stream_is_passed_on() -> None:
    class Ended(QueuedCamera):
        def read(self, timeout_s: float) -> Frame | None:
            raise EndOfStream

    with pytest.raises(EndOfStream):
        discard_queued(Ended(0), lambda: 0.0)


def test_an_image_of_any_size_warms_up_the_recording() -> None:
    warm_up_recording(64, 48)
