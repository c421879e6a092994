"""A reduced image with its tracked points for the browser panel, as one datagram (docs/telemetry.md).

The supervisor sends a few a second after a frame's own datagram has left, if telemetry.view_rate_hz says so.
"""

import json
import struct
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.configuration import Telemetry
from stillarm.common.recorder.telemetry import telemetry_sender

VIEW_MARK = b"SAVW"
_WIDTH_PX = 320  # at most, of the reduced image
_MOST_POINTS = 200
_QUALITY = [cv2.IMWRITE_JPEG_QUALITY, 60]
_MOST_BYTES = 60_000  # a UDP datagram holds 65507


def view_datagram(image: NDArray[np.uint8], points: NDArray[np.float32], number: int) -> bytes | None:
    """VIEW_MARK, the length of a JSON head (u16, little-endian), the head, and a JPEG.

    image: grey, (height, width). points: (n, 2), x and y in pixels of `image`. number: the frame's. The head holds
    frame, width_px and height_px of the reduced image, scale (pixels of `image` for one of it), and points in its own
    pixels. None where it does not fit a datagram.
    """
    height, width = image.shape
    scale = max(1, -(-width // _WIDTH_PX))
    small = cv2.resize(image, (width // scale, height // scale), interpolation=cv2.INTER_AREA)
    _, jpeg = cv2.imencode(".jpg", small, _QUALITY)
    placed = np.round((points[:_MOST_POINTS] + 0.5) / scale - 0.5, 1)
    inside = (placed >= 0.0).all(1) & (placed < (small.shape[1], small.shape[0])).all(1)
    head = json.dumps(
        {
            "frame": number,
            "width_px": small.shape[1],
            "height_px": small.shape[0],
            "scale": scale,
            "points": [[float(x), float(y)] for x, y in placed[inside].tolist()],
        }
    ).encode()
    datagram = VIEW_MARK + struct.pack("<H", len(head)) + head + jpeg.tobytes()
    return datagram if len(datagram) <= _MOST_BYTES else None


class ViewSender:
    """Sends a view at the configured rate, and nothing where that is zero."""

    def __init__(self, settings: Telemetry) -> None:
        """settings: section [telemetry] of the configuration."""
        rate_hz = settings.view_rate_hz if settings.enabled else 0.0
        self._period_s = 1.0 / rate_hz if rate_hz > 0.0 else float("inf")
        self._next_s = float("-inf") if rate_hz > 0.0 else float("inf")
        self._send = telemetry_sender(settings.host, settings.panel_port)

    def show(
        self,
        image: NDArray[np.uint8] | None,
        points: Callable[[], NDArray[np.float32]],
        number: int,
        now_s: float,
    ) -> None:
        """Send the image of `now_s`, s on the monotonic clock, if one is due. points: asked for only then."""
        if now_s < self._next_s or image is None or image.ndim != 2:
            return
        self._next_s = now_s + self._period_s
        datagram = view_datagram(image, points(), number)
        if datagram is not None:
            self._send(datagram)
