"""A live camera through OpenCV: a device number, a device path or a stream's URL.

Reads run in the calling thread: a thread in between would hold a frame more, which is older by then. A
stalled device does not hang the caller for ever, but for how long is the backend's matter: V4L2 and FFmpeg
take CAP_PROP_READ_TIMEOUT_MSEC where it is supported, else give up by themselves after 10 s (V4L2) or 30 s
(FFmpeg). A device that gives nothing for REOPEN_S is closed and opened again, so that a camera that was
unplugged comes back.
"""

import time
from collections.abc import Callable
from typing import Any, Protocol

import cv2

from common.user_error import UserError
from drivers.camera import Frame
from drivers.camera_stamps import StampGate
from drivers.grey_image import grey_image

_OPEN_TIMEOUT_MS = 5000
_READ_TIMEOUT_MS = 500
_RETRY_S = 0.02  # after a failed read, so that an unplugged camera does not take a core
REOPEN_S = 2.0


class Capture(Protocol):
    """The part of cv2.VideoCapture that is used here."""

    def isOpened(self) -> bool:
        """Whether the device is open."""

    def set(self, propId: int, value: float) -> bool:
        """Set a property; False when the backend does not have it."""

    def get(self, propId: int) -> float:
        """A property's value; 0 when the backend does not have it."""

    def read(self) -> tuple[bool, Any]:
        """The next image; may block."""

    def release(self) -> None:
        """Close."""


def open_capture(device: str) -> Capture:
    """cv2.VideoCapture of a device number, path or URL, with time-outs where the backend knows them."""
    timeouts = [
        cv2.CAP_PROP_OPEN_TIMEOUT_MSEC,
        _OPEN_TIMEOUT_MS,
        cv2.CAP_PROP_READ_TIMEOUT_MSEC,
        _READ_TIMEOUT_MS,
    ]
    source: int | str = int(device) if device.isdigit() else device
    capture = cv2.VideoCapture(source, cv2.CAP_ANY, timeouts)
    if not capture.isOpened():
        capture = cv2.VideoCapture(source)
    return capture


class OpenCvCamera:
    """A live camera. Its frames carry no counter, and a stamp where that is plausible as monotonic time."""

    def __init__(
        self,
        device: str,
        width_px: int = 0,
        height_px: int = 0,
        *,
        opener: Callable[[str], Capture] = open_capture,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """width_px, height_px: 0 leaves the camera's own. Opens nothing yet."""
        self._device = device
        self._size = width_px, height_px
        self._opener = opener
        self._clock = clock
        self._sleep = sleep
        self._capture: Capture | None = None
        self._stamps = StampGate()
        self._good_s = 0.0  # when the device last worked, or was last opened
        self.buffer_frames = 0.0  # as read back; 0 where the backend does not say
        self.failed_reads = 0
        self.reopened = 0

    def start(self) -> None:
        """Open the device, set size and one buffer, read both back. Raises UserError when it cannot."""
        capture = self._opener(self._device)
        if not capture.isOpened():
            capture.release()
            raise UserError(
                f"camera.device = {self._device!r}: cannot be opened; give a number (0 is /dev/video0), "
                "a path or a URL, check that it is plugged in and free, and that you are in the group 'video'"
            )
        wanted = (
            ("width_px", cv2.CAP_PROP_FRAME_WIDTH, self._size[0]),
            ("height_px", cv2.CAP_PROP_FRAME_HEIGHT, self._size[1]),
        )
        for _, prop, size in wanted:
            if size:
                capture.set(prop, float(size))
        for key, prop, size in wanted:
            given = round(capture.get(prop))
            if size and given != size:
                capture.release()
                raise UserError(
                    f"camera.{key} = {size}: camera {self._device!r} gives {given} instead; "
                    "set that, or 0 for its own"
                )
        capture.set(cv2.CAP_PROP_BUFFERSIZE, 1.0)
        self.buffer_frames = capture.get(cv2.CAP_PROP_BUFFERSIZE)
        self._capture = capture
        self._good_s = self._clock()

    def read(self, timeout_s: float) -> Frame | None:
        """The next frame, or None when none came: within the time as far as the backend keeps to one."""
        capture = self._capture
        if capture is None:
            self._reopen()
            return None
        good, image = capture.read()
        now = self._clock()
        grey = grey_image(image) if good else None
        if grey is None:
            self.failed_reads += 1
            if now - self._good_s > REOPEN_S:
                self._reopen()
            else:
                self._sleep(min(_RETRY_S, max(0.0, timeout_s)))
            return None
        self._good_s = now
        stamp = self._stamps.accept(capture.get(cv2.CAP_PROP_POS_MSEC) / 1000.0, now)
        return Frame(grey, None, stamp, None)

    def close(self) -> None:
        """Release the device; may be called twice."""
        capture, self._capture = self._capture, None
        if capture is not None:
            capture.release()

    def _reopen(self) -> None:
        if self._clock() - self._good_s <= REOPEN_S:
            self._sleep(_RETRY_S)
            return
        self.close()
        self.reopened += 1
        try:
            self.start()
        except UserError:
            self._good_s = self._clock()  # not back yet: try again in REOPEN_S
