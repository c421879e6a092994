"""A Raspberry Pi's camera through picamera2 and libcamera. Its stamp refers to the first row, on CLOCK_BOOTTIME."""

from typing import Any

from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera_stamps import StampReference
from stillarm.drivers.cameras.vendors.stream_camera import (
    BUFFERS,
    BackendLost,
    Grab,
    missing_package,
    no_camera,
)

_REMEDY = (
    "apt install python3-picamera2, and make the virtual environment with --system-site-packages, or "
    "pip install 'stillarm[libcamera]'"
)
_DEFAULT_SIZE = (640, 480)


class LibcameraBackend:
    """stillarm.drivers.cameras.vendors.stream_camera.Backend for picamera2."""

    reference = StampReference.EXPOSURE_START
    counter_modulus = 0

    def __init__(self, config: CameraDevice) -> None:
        """Opens nothing."""
        self._config = config
        self._camera: Any = None
        self._size = _DEFAULT_SIZE

    def open(self) -> list[str]:
        """Open the camera by its index. Raises UserError."""
        try:
            from picamera2 import Picamera2
        except ImportError:
            raise missing_package("libcamera", "picamera2", _REMEDY) from None
        self.close()
        config = self._config
        if config.trigger != "freerun":
            raise UserError(f"camera.trigger = {config.trigger!r}: libcamera has no trigger; use 'freerun'")
        found = [str(info.get("Model", "?")) for info in Picamera2.global_camera_info()]
        if not config.device.isdigit() or int(config.device) >= len(found):
            raise no_camera(config, found, "check its ribbon cable (`rpicam-hello --list-cameras` shows it)")
        wanted = (config.width_px or _DEFAULT_SIZE[0], config.height_px or _DEFAULT_SIZE[1])
        controls: dict[str, Any] = {}
        if config.exposure_s:
            controls |= {"AeEnable": False, "ExposureTime": round(config.exposure_s * 1e6)}
        if config.gain >= 0.0:
            controls |= {"AnalogueGain": config.gain}
        if config.frame_rate_hz:
            period_us = round(1e6 / config.frame_rate_hz)
            controls |= {"FrameDurationLimits": (period_us, period_us)}
        try:
            camera = Picamera2(int(config.device))
            camera.configure(
                camera.create_video_configuration(
                    main={"size": wanted, "format": "YUV420"},
                    controls=controls,
                    buffer_count=max(2, config.buffers or BUFFERS),
                    queue=False,
                )
            )
            camera.start()
        except RuntimeError as error:
            raise no_camera(config, found, f"it cannot be opened ({' '.join(str(error).split())})") from None
        self._camera = camera
        self._size = tuple(camera.camera_configuration()["main"]["size"])
        if config.width_px and self._size != wanted:
            given = "x".join(map(str, self._size))
            self.close()
            raise UserError(
                f"camera.width_px = {config.width_px}: the camera gives {given} instead; set that, or 0"
            )
        return []

    def grab(self, timeout_s: float) -> Grab | None:
        """The next image. Raises BackendLost if libcamera gives up."""
        if self._camera is None:
            raise BackendLost
        try:
            request = self._camera.capture_request(wait=timeout_s)
        except TimeoutError:
            return None
        except RuntimeError:
            raise BackendLost from None
        try:
            metadata = request.get_metadata()
            width, height = self._size
            image = request.make_array("main")[:height, :width].copy()  # YUV420: the upper part is grey
            stamp_ns, exposure_us = metadata.get("SensorTimestamp"), metadata.get("ExposureTime")
            return Grab(
                image,
                None,
                stamp_ns * 1e-9 if stamp_ns else None,
                exposure_us * 1e-6 if exposure_us else None,
            )
        finally:
            request.release()

    def trigger(self) -> None:
        """Do nothing: libcamera has no trigger."""

    def close(self) -> None:
        """Release the camera; may be called twice."""
        camera, self._camera = self._camera, None
        if camera is not None:
            camera.stop()
            camera.close()
