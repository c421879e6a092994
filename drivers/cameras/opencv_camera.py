"""A live camera through OpenCV: a device number, a device path or a stream's URL.

Reads run in the calling thread: a thread in between would hold one more frame, which would be older by then. A stalled
device blocks the caller for a limited time, which the backend determines: V4L2 and FFmpeg use
CAP_PROP_READ_TIMEOUT_MSEC if it is supported, and otherwise give up after 10 s (V4L2) or 30 s (FFmpeg). A device that
delivers nothing for REOPEN_S is closed and opened again, so that an unplugged camera comes back.
"""

import time
from collections.abc import Callable
from typing import Any, Protocol

import cv2

from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera import Frame
from stillarm.drivers.cameras.camera_stamps import StampGate, StampReference, mid_exposure_s
from stillarm.drivers.cameras.grey_image import grey_image

_OPEN_TIMEOUT_MS = 5000
_READ_TIMEOUT_MS = 500
_RETRY_S = 0.02  # wait after a failed read, so that an unplugged camera does not occupy a core
REOPEN_S = 2.0
_MANUAL_EXPOSURE = 1.0  # V4L2_EXPOSURE_MANUAL
_EXPOSURE_UNIT_S = 1e-4


class Capture(Protocol):
    """The part of cv2.VideoCapture that is used here."""

    def isOpened(self) -> bool:
        """Whether the device is open."""

    def set(self, propId: int, value: float) -> bool:
        """Set a property. Returns False if the backend does not have it."""

    def get(self, propId: int) -> float:
        """A property's value; 0 if the backend does not have it."""

    def read(self) -> tuple[bool, Any]:
        """The next image; may block."""

    def release(self) -> None:
        """Close."""

    def getBackendName(self) -> str:
        """Name of the OpenCV backend."""


def set_capture(capture: Capture, config: CameraDevice) -> tuple[list[str], float | None]:
    """Set exposure, gain, rate and buffers. Returns a line for each refused value, and the exposure in use, s.

    Only V4L2 defines the unit of its exposure: 100 us (V4L2_CID_EXPOSURE_ABSOLUTE); manual exposure is mode 1.
    """
    notes = []

    def ask(key: str, wanted: float, prop: int, value: float, unit: float) -> None:
        capture.set(prop, value)
        given = capture.get(prop) * unit
        if abs(given - wanted) > 0.02 * abs(wanted):
            notes.append(
                f"camera.{key} = {wanted:g}: the camera took {given:g} instead; set that, or 0 for its default"
            )

    v4l2 = capture.getBackendName() == "V4L2"
    if config.exposure_s and v4l2:
        capture.set(cv2.CAP_PROP_AUTO_EXPOSURE, _MANUAL_EXPOSURE)
        units = config.exposure_s / _EXPOSURE_UNIT_S
        ask("exposure_s", config.exposure_s, cv2.CAP_PROP_EXPOSURE, round(units), _EXPOSURE_UNIT_S)
    elif config.exposure_s:
        notes.append(
            f"camera.exposure_s = {config.exposure_s:g}: OpenCV's {capture.getBackendName()} does not define the unit "
            "of its exposure; set it with the camera's own program, and leave this at 0"
        )
    if config.gain >= 0.0:
        ask("gain", config.gain, cv2.CAP_PROP_GAIN, config.gain, 1.0)
    if config.frame_rate_hz:
        ask("frame_rate_hz", config.frame_rate_hz, cv2.CAP_PROP_FPS, config.frame_rate_hz, 1.0)
    capture.set(cv2.CAP_PROP_BUFFERSIZE, float(config.buffers or 1))
    units = capture.get(cv2.CAP_PROP_EXPOSURE) if v4l2 else 0.0
    manual = capture.get(cv2.CAP_PROP_AUTO_EXPOSURE) == _MANUAL_EXPOSURE
    return notes, units * _EXPOSURE_UNIT_S if manual and units > 0.0 else None


def open_capture(device: str) -> Capture:
    """cv2.VideoCapture of a device number, path or URL, with time-outs if the backend supports them."""
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
    """A live camera. Its frames have no counter, and a stamp if that is plausible as monotonic time."""

    def __init__(
        self,
        device: str,
        width_px: int = 0,
        height_px: int = 0,
        *,
        config: CameraDevice | None = None,
        opener: Callable[[str], Capture] = open_capture,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """width_px, height_px: 0 keeps the camera's default. config: exposure, gain, rate and buffers to set. Opens
        nothing yet.
        """
        self._settings = config or CameraDevice()
        self._reference = (
            StampReference.EXPOSURE_START
            if self._settings.stamp_reference == "auto"
            else StampReference(self._settings.stamp_reference)
        )
        self._exposure_s: float | None = None
        self.notes: list[str] = []
        self._device = device
        self._size = width_px, height_px
        self._opener = opener
        self._clock = clock
        self._sleep = sleep
        self._capture: Capture | None = None
        self._stamps = StampGate()
        self._good_s = 0.0  # when the device last worked, or was last opened
        self.buffer_frames = 0.0  # as read back; 0 if the backend does not report it
        self.failed_reads = 0
        self.reopened = 0

    def start(self) -> None:
        """Open the device, set size and one buffer, read both back. Raises UserError on failure."""
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
                    "set that, or 0 for its default"
                )
        self.notes, self._exposure_s = set_capture(capture, self._settings)
        self.buffer_frames = capture.get(cv2.CAP_PROP_BUFFERSIZE)
        self._capture = capture
        self._good_s = self._clock()

    def read(self, timeout_s: float) -> Frame | None:
        """The next frame, or None if none arrived in time, as far as the backend supports time-outs."""
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
        if stamp is not None:
            stamp = mid_exposure_s(stamp, self._reference, self._exposure_s)
        return Frame(grey, None, stamp, self._exposure_s)

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
            self._good_s = self._clock()  # still absent: try again in REOPEN_S
