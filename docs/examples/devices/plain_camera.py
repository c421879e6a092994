"""An invented maker's cameras, through an invented package `plaincam`."""

from typing import Any

from stillarm.common.files.configuration import CameraDevice
from stillarm.drivers.cameras.camera_stamps import StampReference
from stillarm.drivers.cameras.vendors.stream_camera import (
    BackendLost,
    Grab,
    chosen,
    missing_package,
    no_camera,
)


class PlainBackend:
    """stillarm.drivers.cameras.vendors.stream_camera.Backend for plaincam."""

    reference = StampReference.EXPOSURE_START  # the maker's manual says so
    counter_modulus = 1 << 16

    def __init__(self, config: CameraDevice) -> None:
        """Opens nothing."""
        self._config = config
        self._camera: Any = None

    def open(self) -> list[str]:
        """Open the configured camera and stream. Raises UserError."""
        try:
            import plaincam
        except ImportError:
            raise missing_package("plain", "plaincam", "pip install 'stillarm[plain]'") from None
        self.close()
        serials = plaincam.serials()
        place = chosen(self._config, serials)
        if place is None:
            raise no_camera(self._config, serials, "check its cable and power")
        self._camera = plaincam.Camera(serials[place])
        set_s = self._camera.set_exposure(self._config.exposure_s)
        if self._config.exposure_s in (0.0, set_s):
            return []
        return [f"camera.exposure_s = {self._config.exposure_s:g}: the camera set {set_s:g}"]

    def grab(self, timeout_s: float) -> Grab | None:
        """The next image."""
        if self._camera is None:
            raise BackendLost
        try:
            image = self._camera.next(timeout_s)
        except OSError:
            raise BackendLost from None
        return image and Grab(image.pixels, image.number, 1e-9 * image.stamp_ns, 1e-6 * image.exposure_us)

    def trigger(self) -> None:
        """Expose once."""
        if self._camera is not None:
            self._camera.trigger()

    def close(self) -> None:
        """Release the camera."""
        if self._camera is not None:
            self._camera.close()
            self._camera = None
