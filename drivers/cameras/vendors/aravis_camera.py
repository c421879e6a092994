"""GigE Vision and USB3 Vision cameras through Aravis (LGPL), without vendor software; "Fake_1" is Aravis's fake."""

from typing import Any

import numpy as np

from stillarm.common.files.configuration import CameraDevice
from stillarm.drivers.cameras.camera_stamps import StampReference
from stillarm.drivers.cameras.vendors.camera_features import NodeFeatures, exposure_s, set_features
from stillarm.drivers.cameras.vendors.stream_camera import (
    BUFFERS,
    BackendLost,
    Grab,
    chosen,
    missing_package,
    no_camera,
)

_REMEDY = (
    "apt install gir1.2-aravis-0.8 python3-gi, and make the virtual environment with --system-site-packages"
)
FAKE = "Fake_1"


class AravisBackend:
    """stillarm.drivers.cameras.vendors.stream_camera.Backend for Aravis."""

    reference = StampReference.EXPOSURE_START
    counter_modulus = 65535

    def __init__(self, config: CameraDevice) -> None:
        """Opens nothing."""
        self._config = config
        self._aravis: Any = None
        self._camera: Any = None
        self._stream: Any = None
        self._exposure_s: float | None = None

    def open(self) -> list[str]:
        """Open the camera by its identifier, serial number or index. Raises UserError."""
        try:
            import gi

            gi.require_version("Aravis", "0.8")
            from gi.repository import Aravis, GLib
        except (ImportError, ValueError):
            raise missing_package("aravis", "gi with Aravis 0.8", _REMEDY) from None
        self.close()
        self._aravis, self._error = Aravis, GLib.Error
        if self._config.device == FAKE:
            Aravis.enable_interface("Fake")
        Aravis.update_device_list()
        places = range(Aravis.get_n_devices())
        identifiers = [Aravis.get_device_id(place) for place in places]
        serials = [Aravis.get_device_serial_nbr(place) for place in places]
        place = (
            identifiers.index(self._config.device)
            if self._config.device in identifiers
            else chosen(self._config, serials)
        )
        if place is None:
            raise no_camera(
                self._config,
                identifiers,
                "check its cable and address (`arv-tool-0.8` lists), or correct the name",
            )
        try:
            camera = Aravis.Camera.new(identifiers[place])
            features = _features(camera.get_device(), self._error)
            notes = set_features(features, self._config)
            self._exposure_s = exposure_s(features)
            stream = camera.create_stream(None, None)
            payload = camera.get_payload()
            for _ in range(max(2, self._config.buffers or BUFFERS)):
                stream.push_buffer(Aravis.Buffer.new_allocate(payload))
            camera.start_acquisition()
        except self._error as error:
            raise no_camera(
                self._config,
                identifiers,
                f"it cannot be opened ({' '.join(str(error).split())}); close what else uses it",
            ) from None
        self._camera, self._stream = camera, stream
        return notes

    def grab(self, timeout_s: float) -> Grab | None:
        """The next image in order of arrival."""
        if self._stream is None:
            raise BackendLost
        buffer = self._stream.timeout_pop_buffer(max(1, round(timeout_s * 1e6)))
        if buffer is None:
            return None
        try:
            if buffer.get_status() != self._aravis.BufferStatus.SUCCESS:
                return Grab(None, whole=False)
            width, height = buffer.get_image_width(), buffer.get_image_height()
            data = np.frombuffer(buffer.get_data(), np.uint8)
            if data.size < width * height:
                return Grab(None, whole=False)
            image = data[: width * height].reshape(height, width).copy()
            stamp_ns = buffer.get_timestamp()
            return Grab(
                image, int(buffer.get_frame_id()), stamp_ns * 1e-9 if stamp_ns else None, self._exposure_s
            )
        finally:
            self._stream.push_buffer(buffer)

    def trigger(self) -> None:
        """Expose once."""
        if self._camera is not None:
            self._camera.software_trigger()

    def close(self) -> None:
        """Release the camera; may be called twice."""
        camera, self._camera, self._stream = self._camera, None, None
        if camera is not None:
            try:
                camera.stop_acquisition()
            except self._error:  # already gone
                return


def _features(device: Any, error: type[Exception]) -> NodeFeatures:
    """The features of an Aravis device."""

    def put(name: str, value: float | str | bool) -> None:
        if not device.is_feature_available(name):
            raise KeyError(name)
        kinds = {bool: "boolean", str: "string", float: "float", int: "integer"}
        getattr(device, f"set_{kinds[type(value)]}_feature_value")(name, value)

    def get(name: str) -> Any:
        if not device.is_feature_available(name):
            raise KeyError(name)
        try:
            return device.get_float_feature_value(name)
        except error:
            return device.get_integer_feature_value(name)

    return NodeFeatures(put, get, (KeyError, error))
