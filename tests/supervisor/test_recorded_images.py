"""Recorded images tracked again: number for number, up to the first that the recorder lost."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace as with_fields

from stillarm.common.files.configuration import Tracker
from stillarm.common.recording.reader import Recording, open_recording
from stillarm.common.recording.topics import ImageSample
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera import Frame
from stillarm.supervisor.recorded_images import compare_with_live, image_sample, recorded_frame
from stillarm.supervisor.step import Supervisor
from tests.fixtures.recordings import written
from tests.fixtures.tracked_images import COUNT, tracked_images


def recording_of(messages: list[ImageSample], folder) -> Recording:
    path = folder / "images.mcap"
    path.write_bytes(written([("/images", one) for one in messages]))
    return open_recording(path)


def test_a_complete_recording_gives_the_same_numbers(tmp_path):
    comparison = compare_with_live(recording_of(tracked_images(), tmp_path))
    assert (comparison.frames, comparison.different, comparison.not_compared) == (COUNT, 0, 0)


def test_a_number_that_differs_is_told(tmp_path):
    messages = tracked_images()
    messages[5] = with_fields(messages[5], displacement_px=messages[5].displacement_px + 1e-12)
    comparison = compare_with_live(recording_of(messages, tmp_path))
    assert comparison.different == 1
    assert comparison.first_difference is not None
    assert comparison.first_difference.startswith("frame 5, displacement_px: ")


def test_after_a_lost_image_nothing_is_compared(tmp_path):
    """The tracker remembers an image that the recording does not hold."""
    comparison = compare_with_live(recording_of(tracked_images(lost_from=7), tmp_path))
    assert (comparison.frames, comparison.different, comparison.not_compared) == (7, 0, COUNT - 8)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**31 - 1), st.none() | st.integers(0, 9), st.none() | st.floats(0.0, 1e6))
def test_a_frame_comes_back_as_it_was(seed, counter, stamp_s):
    image = np.random.default_rng(seed).integers(0, 256, (9, 13), dtype=np.uint8)
    supervisor = Supervisor(Tracker())
    frame = Frame(image, counter, stamp_s, None)
    back = recorded_frame(image_sample(0.0, frame, supervisor.step(frame, -1), 0))
    assert np.array_equal(back.image, image)
    assert (back.counter, back.stamp_s, back.exposure_s) == (counter, stamp_s, None)


def test_a_damaged_image_is_one_clear_line():
    damaged = with_fields(tracked_images()[3], data="AAAA")
    with pytest.raises(UserError, match=r"/images at 0\.06 s: the image cannot be decoded"):
        recorded_frame(damaged)
