"""The ring of images: in order, whole, and honest about what was overwritten."""

import os
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.memory.shared_memory import SharedBlock
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.frame_ring import FrameRingReader, FrameRingWriter

WIDTH, HEIGHT = 33, 7  # not a multiple of anything


def _image(index: int) -> np.ndarray:
    return (np.arange(WIDTH * HEIGHT).reshape(HEIGHT, WIDTH) * 3 + index * 7).astype(np.uint8)


@pytest.fixture
def name() -> Iterator[str]:
    name = f"test-ring-{os.getpid()}"
    yield name
    SharedBlock(name, 64, create=True).close()  # removes what a failed test left behind


@settings(max_examples=60, deadline=None)
@given(slots=st.integers(1, 5), moves=st.lists(st.sampled_from(["publish", "take"]), max_size=60))
def test_frames_come_in_order_or_are_counted_as_lost(slots: int, moves: list[str]) -> None:
    writer = FrameRingWriter(f"test-ring-{os.getpid()}-h", WIDTH, HEIGHT, slots)
    reader = FrameRingReader(f"test-ring-{os.getpid()}-h")
    queue: list[int] = []  # the model: a queue as deep as the ring, which loses its oldest
    published, lost = 0, 0
    for move in moves:
        if move == "publish":
            writer.publish(_image(published), 100 + published, 0.5 * published, 0.015)
            queue.append(published)
            published += 1
            if len(queue) > slots:
                queue.pop(0)
                lost += 1
            continue
        frame = reader.take()
        assert (frame is None) == (not queue)
        if frame is not None:
            index = queue.pop(0)
            assert (frame.counter, frame.stamp_s, frame.exposure_s) == (100 + index, 0.5 * index, 0.015)
            np.testing.assert_array_equal(frame.image, _image(index))
            assert reader.lost == lost
    writer.close()
    reader.close()


def test_what_is_absent_stays_absent(name: str) -> None:
    writer, image = FrameRingWriter(name, WIDTH, HEIGHT, 2), _image(0)
    reader = FrameRingReader(name)
    writer.publish(image, None, None, None)
    frame = reader.take()
    assert frame is not None
    assert (frame.counter, frame.stamp_s, frame.exposure_s) == (None, None, None)
    writer.close()
    reader.close()


def test_a_frame_taken_is_safe_from_the_writer(name: str) -> None:
    writer, reader = FrameRingWriter(name, WIDTH, HEIGHT, 2), FrameRingReader(name)
    writer.publish(_image(1), 1, None, None)
    frame = reader.take()
    assert frame is not None
    for index in range(2, 9):
        writer.publish(_image(index), index, None, None)
    np.testing.assert_array_equal(frame.image, _image(1))
    writer.close()
    reader.close()


def test_a_frame_overwritten_while_it_is_copied_is_never_handed_out(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    writer, reader = FrameRingWriter(name, WIDTH, HEIGHT, 2), FrameRingReader(name)
    writer.publish(_image(0), 0, None, None)
    original = np.copyto
    published = 1

    def torn(destination: np.ndarray, source: np.ndarray) -> None:
        nonlocal published
        original(destination[:3], source[:3])
        while published < 4:  # the writer comes round in the middle of the copy
            writer.publish(_image(published), published, None, None)
            published += 1
        original(destination[3:], source[3:])

    monkeypatch.setattr(np, "copyto", torn)
    frame = reader.take()
    assert frame is not None
    assert frame.counter == 2
    np.testing.assert_array_equal(frame.image, _image(2))
    assert reader.lost == 2
    writer.close()
    reader.close()


def test_a_writer_that_died_in_the_middle_of_a_frame_gives_no_frame(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    writer, reader = FrameRingWriter(name, WIDTH, HEIGHT, 2), FrameRingReader(name)

    class Broken:
        def __setitem__(self, key: object, value: object) -> None:
            raise KeyboardInterrupt

    monkeypatch.setattr(writer, "_images", [Broken(), Broken(), Broken()])
    with pytest.raises(KeyboardInterrupt):
        writer.publish(_image(0), 0, None, None)
    monkeypatch.undo()
    assert reader.take() is None
    assert reader.lost == 0
    writer.close()
    reader.close()


def test_images_of_another_shape_are_refused(name: str) -> None:
    writer = FrameRingWriter(name, WIDTH, HEIGHT, 2)
    with pytest.raises(ValueError, match="the ring takes"):
        writer.publish(np.zeros((HEIGHT, WIDTH + 1), np.uint8), 0, None, None)
    with pytest.raises(ValueError, match="the ring takes"):
        writer.publish(np.zeros((HEIGHT, WIDTH)), 0, None, None)  # type: ignore[arg-type]
    writer.close()


def test_a_ring_that_is_absent_or_never_completed_is_one_line(name: str) -> None:
    with pytest.raises(UserError):
        FrameRingReader(name)
    block = SharedBlock(name, 4096, create=True)
    with pytest.raises(UserError, match="never completed") as raised:
        FrameRingReader(name)
    assert "\n" not in str(raised.value)
    block.close()


def test_requests_reach_the_writer(name: str) -> None:
    writer, reader = FrameRingWriter(name, WIDTH, HEIGHT, 2), FrameRingReader(name)
    reader.request(3)
    reader.request(1)
    assert writer.requested() == 4
    writer.close()
    reader.close()
