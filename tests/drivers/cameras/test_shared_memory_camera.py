"""The camera whose frames come from another process, in virtual time: waiting, stalls, restarts, requests."""

import os
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from stillarm.common.memory.shared_memory import SharedBlock
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.frame_ring import FrameRingWriter
from stillarm.drivers.cameras.shared_memory_camera import SharedMemoryCamera


class _Time:
    """A clock that advances during sleep(), with events at given instants."""

    def __init__(self) -> None:
        self.now = 1000.0
        self.naps = 0
        self.longest_nap = 0.0
        self.events: list[tuple[float, Callable[[], None]]] = []

    def clock(self) -> float:
        return self.now

    def sleep(self, duration_s: float) -> None:
        assert duration_s >= 0.0
        self.now += max(duration_s, 1e-6)
        self.naps += 1
        self.longest_nap = max(self.longest_nap, duration_s)
        while self.events and self.events[0][0] <= self.now:
            self.events.pop(0)[1]()


@pytest.fixture
def name() -> Iterator[str]:
    name = f"test-shm-camera-{os.getpid()}"
    yield name
    SharedBlock(name, 64, create=True).close()


def _writer(name: str, width: int = 16) -> FrameRingWriter:
    return FrameRingWriter(name, width, 8, 4)


def _publish(writer: FrameRingWriter, counter: int, width: int = 16) -> None:
    writer.publish(np.full((8, width), counter, np.uint8), counter, None, 0.015)


def test_without_a_provider_start_names_the_remedy(name: str) -> None:
    with pytest.raises(UserError, match=r"camera\.device") as raised:
        SharedMemoryCamera(name, wait_s=0.0).start()
    assert "start it" in str(raised.value)
    assert "\n" not in str(raised.value)


def test_frames_from_before_the_start_are_passed_over_and_the_rest_come_in_order(name: str) -> None:
    writer, time = _writer(name), _Time()
    _publish(writer, 1)
    camera = SharedMemoryCamera(name, clock=time.clock, sleep=time.sleep)
    camera.start()
    assert camera.read(0.0) is None
    for counter in (2, 3):
        _publish(writer, counter)
    for counter in (2, 3):
        frame = camera.read(0.0)
        assert frame is not None
        assert frame.counter == counter
        assert frame.image[0, 0] == counter
    writer.close()
    camera.close()
    camera.close()


def test_it_waits_in_short_sleeps_and_a_stall_ends_in_none(name: str) -> None:
    writer, time = _writer(name), _Time()
    camera = SharedMemoryCamera(name, clock=time.clock, sleep=time.sleep)
    camera.start()
    begin = time.now
    time.events.append((begin + 0.05, lambda: _publish(writer, 1)))
    frame = camera.read(0.2)
    assert frame is not None
    assert 0.05 <= time.now - begin <= 0.0506
    assert time.longest_nap <= 0.0005
    begin = time.now
    assert camera.read(0.2) is None
    assert time.now - begin == pytest.approx(0.2, abs=1e-5)
    assert time.naps < 1000
    writer.close()
    camera.close()


def test_it_survives_a_restart_of_its_provider_even_with_another_image_size(name: str) -> None:
    first, time = _writer(name), _Time()
    camera = SharedMemoryCamera(name, clock=time.clock, sleep=time.sleep)
    camera.start()
    _publish(first, 1)
    assert camera.read(0.1) is not None
    first.close()
    assert camera.read(0.3) is None  # away
    second = _writer(name, width=32)
    _publish(second, 0, width=32)
    frame = camera.read(0.3)
    assert frame is not None
    assert frame.counter == 0
    assert frame.image.shape == (8, 32)
    third = _writer(name)  # replaced without ever having been away, as after a kill
    _publish(third, 5)
    frame = camera.read(0.3)
    assert frame is not None
    assert frame.counter == 5
    third.close()
    second.close()
    camera.close()


def test_losses_are_counted_across_restarts(name: str) -> None:
    first, time = _writer(name), _Time()
    camera = SharedMemoryCamera(name, clock=time.clock, sleep=time.sleep)
    camera.start()
    for counter in range(10):
        _publish(first, counter)
    frame = camera.read(0.0)
    assert frame is not None
    assert frame.counter == 9  # far behind: only the newest is worth its time
    assert camera.lost == 9
    for counter in range(10, 13):
        _publish(first, counter)
    first.close()
    held = [camera.read(0.3) for _ in range(3)]  # what was handed over before is still good
    assert [frame is not None and frame.counter for frame in held] == [10, 11, 12]
    assert camera.read(0.3) is None
    assert camera.lost == 9
    camera.close()


def test_a_triggered_provider_is_asked_once_for_each_frame_and_again_when_it_never_answers(name: str) -> None:
    writer, time = _writer(name), _Time()
    camera = SharedMemoryCamera(name, in_flight=2, clock=time.clock, sleep=time.sleep)
    camera.start()
    assert writer.requested() == 2
    for counter in range(3):
        _publish(writer, counter)
        assert camera.read(0.1) is not None
    assert writer.requested() == 5
    assert camera.read(0.5) is None
    assert writer.requested() == 5  # it may still be under way
    assert camera.read(0.8) is None
    assert writer.requested() == 7
    writer.close()
    camera.close()


def test_reading_before_the_start_is_a_mistake_of_the_program(name: str) -> None:
    with pytest.raises(RuntimeError):
        SharedMemoryCamera(name).read(0.0)
