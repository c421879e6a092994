"""The supervisor's views: at their rate, small enough for a datagram, and none where they are not wanted."""

import socket

import numpy as np
import pytest

from stillarm.common.files.configuration import Telemetry
from stillarm.supervisor.view import VIEW_MARK, ViewSender, view_datagram

IMAGE = np.random.default_rng(1).integers(0, 255, (480, 640), np.uint8)
POINTS = np.zeros((100, 2), np.float32)


@pytest.mark.parametrize("shape", [(64, 64), (480, 640), (1080, 1920), (3000, 4096), (4096, 64)])
def test_a_view_of_any_image_fits_a_datagram_or_is_left_out(shape: tuple[int, int]) -> None:
    noise = np.random.default_rng(0).integers(0, 255, shape, np.uint8)
    datagram = view_datagram(noise, POINTS, 1)
    assert datagram is None or (datagram.startswith(VIEW_MARK) and len(datagram) <= 60_000)


def test_views_are_sent_at_their_rate_and_points_are_asked_for_only_then() -> None:
    asked = 0

    def points() -> np.ndarray:  # type: ignore[type-arg]
        nonlocal asked
        asked += 1
        return POINTS

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(5.0)
        port = listener.getsockname()[1]
        sender = ViewSender(Telemetry(panel_port=port, view_rate_hz=4.0))
        for frame in range(66):  # a second
            sender.show(IMAGE, points, frame, frame / 65.0)
        assert 4 <= asked <= 5
        assert [listener.recv(65_536)[:4] for _ in range(asked)] == [VIEW_MARK] * asked
        quiet = ViewSender(Telemetry(panel_port=port))
        quiet.show(IMAGE, points, 0, 0.0)
        sender.show(None, points, 0, 100.0)
        assert asked <= 5
