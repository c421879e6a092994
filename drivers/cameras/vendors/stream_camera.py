"""A camera of any vendor: the common part of the drivers; a backend contains the vendor's part."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera import Frame
from stillarm.drivers.cameras.camera_stamps import DeviceStampGate, StampReference, mid_exposure_s
from stillarm.drivers.cameras.grey_image import grey_image
from stillarm.drivers.cameras.vendors.frame_counter import FrameCounter

REOPEN_S = 2.0
BUFFERS = 4


@dataclass(frozen=True, slots=True)
class Grab:
    """An image as the vendor's package delivers it. whole: False for an image with holes.

    stamp_s: on the camera's clock, of the instant that the backend's reference names; None, or 0, if there is none.
    """

    image: Any
    counter: int | None = None
    stamp_s: float | None = None
    exposure_s: float | None = None
    whole: bool = True


class BackendLost(Exception):
    """The camera is gone."""


class Backend(Protocol):
    """A vendor's package. Constructing opens nothing."""

    reference: StampReference
    counter_modulus: int

    def open(self) -> list[str]:
        """Open, set up and stream. Returns a line for each refused setting. Raises UserError."""

    def grab(self, timeout_s: float) -> Grab | None:
        """The next image; None if none arrived in time. Raises BackendLost."""

    def trigger(self) -> None:
        """Expose once, if the configuration asks for a software trigger."""

    def close(self) -> None:
        """Stop and release; may be called twice."""


class StreamCamera:
    """Frames of a backend: grey, with increasing counts, dated at mid-exposure; implements
    stillarm.drivers.cameras.camera.Camera.

    A camera that disappears, or delivers nothing for REOPEN_S, is closed and opened again. An image with holes, or of
    another size than the first, is skipped and counted. With a software trigger, `in_flight` exposures are pending.
    """

    def __init__(
        self,
        backend: Backend,
        config: CameraDevice,
        *,
        in_flight: int = 1,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Opens nothing."""
        self._backend = backend
        self._reference = (
            backend.reference if config.stamp_reference == "auto" else StampReference(config.stamp_reference)
        )
        self._software = config.trigger == "software"
        self._in_flight = in_flight
        self._clock, self._sleep = clock, sleep
        self._counter = FrameCounter(backend.counter_modulus)
        self._stamps = DeviceStampGate()
        self._shape: tuple[int, ...] | None = None
        self._open = False
        self._good_s = 0.0
        self.notes: list[str] = []
        self.incomplete = 0
        self.reopened = 0

    @property
    def wrong_counters(self) -> int:
        """Number of frame counts that could not follow their predecessor."""
        return self._counter.wrong

    def start(self) -> None:
        """Open the camera and start streaming. Raises UserError with a remedy."""
        self.notes = self._backend.open()
        self._open = True
        self._good_s = self._clock()
        self._trigger(self._in_flight)

    def read(self, timeout_s: float) -> Frame | None:
        """The next frame, or None if none arrived in time."""
        if not self._open:
            self._reopen(timeout_s)
            return None
        try:
            grab = self._backend.grab(timeout_s)
        except BackendLost:
            self._close()
            return None
        now = self._clock()
        if grab is None:
            if now - self._good_s > REOPEN_S:
                self._close()
            else:
                self._trigger(1)  # a trigger is lost if the camera was not ready
            return None
        self._trigger(1)
        grey = grey_image(grab.image) if grab.whole else None
        if grey is None or (self._shape is not None and grey.shape != self._shape):
            self.incomplete += 1
            return None
        self._shape = grey.shape
        self._good_s = now
        counter = None if grab.counter is None else self._counter.accept(grab.counter)
        stamp = self._stamps.accept(grab.stamp_s)
        if stamp is not None:
            stamp = mid_exposure_s(stamp, self._reference, grab.exposure_s)
        return Frame(grey, counter, stamp, grab.exposure_s)

    def close(self) -> None:
        """Stop streaming and release the device; may be called twice."""
        self._open = False
        self._backend.close()

    def _trigger(self, times: int) -> None:
        if self._software:
            for _ in range(times):
                self._backend.trigger()

    def _close(self) -> None:
        self._backend.close()
        self._open = False
        self._good_s = self._clock()

    def _reopen(self, timeout_s: float) -> None:
        left = self._good_s + REOPEN_S - self._clock()
        if left > 0.0:
            self._sleep(min(left, timeout_s))
            return
        self.reopened += 1
        try:
            self._backend.open()
        except UserError:
            self._good_s = self._clock()  # still absent: try again in REOPEN_S
            return
        self._open = True
        self._good_s = self._clock()
        self._trigger(self._in_flight)


def missing_package(driver: str, package: str, remedy: str) -> UserError:
    """The error for a missing vendor package."""
    return UserError(f"camera.driver = {driver!r}: the package {package} is not installed; {remedy}")


def no_camera(config: CameraDevice, found: list[str], remedy: str) -> UserError:
    """The error for a missing camera."""
    there = f"found: {', '.join(found)}" if found else "none found"
    return UserError(f"camera.device = {config.device!r}: no such camera ({there}); {remedy}")


def chosen(config: CameraDevice, serials: list[str]) -> int | None:
    """Index of the configured camera among those found: by serial number, or else by index."""
    if config.device in serials:
        return serials.index(config.device)
    place = int(config.device) if config.device.isdigit() else -1
    return place if 0 <= place < len(serials) else None
