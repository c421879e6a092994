"""A view from the supervisor reaches the page as it was; anything else is dropped."""

import json
import struct

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.panel.live.view import VIEW_KIND, VIEW_MARK, view_message
from stillarm.supervisor.view import view_datagram


def test_a_view_reaches_the_page() -> None:
    image = np.random.default_rng(0).integers(0, 255, (480, 640), np.uint8)
    points = np.array([[0.5, 0.5], [639.0, 479.0], [700.0, 10.0]], np.float32)
    datagram = view_datagram(image, points, 12)
    assert datagram is not None
    message = view_message(datagram)
    assert message is not None and message[0] == VIEW_KIND
    (length,) = struct.unpack_from("<H", message, 2)
    head = json.loads(message[4 : 4 + length])
    assert (head["frame"], head["scale"], head["width_px"], head["height_px"]) == (12, 2, 320, 240)
    assert len(head["points"]) == 2  # the third lies outside the image
    shown = cv2.imdecode(np.frombuffer(message[4 + length :], np.uint8), cv2.IMREAD_GRAYSCALE)
    assert shown is not None and shown.shape == (240, 320)


@pytest.mark.parametrize(
    "damaged",
    [b"", VIEW_MARK, VIEW_MARK + b"\xff\xff{}", VIEW_MARK + b"\x02\x00{}\xff\xd8", VIEW_MARK + b"\x00"],
)
def test_a_damaged_view_is_dropped(damaged: bytes) -> None:
    assert view_message(damaged) is None


@given(st.binary(max_size=100))
def test_any_bytes_are_no_error(data: bytes) -> None:
    view_message(VIEW_MARK + data)
