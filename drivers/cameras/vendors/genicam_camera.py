"""Any GenICam camera through harvesters and its vendor's transport layer (.cti, camera.producer)."""

from pathlib import Path
from typing import Any

import numpy as np

from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError
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

_CHANNELS = {1: 0, 3: 3, 4: 4}


class GenicamBackend:
    """stillarm.drivers.cameras.vendors.stream_camera.Backend for harvesters."""

    reference = StampReference.EXPOSURE_START
    counter_modulus = 65535  # GigE Vision's block number; other counters never step so far at once

    def __init__(self, config: CameraDevice) -> None:
        """Opens nothing."""
        self._config = config
        self._harvester: Any = None
        self._acquirer: Any = None
        self._timeout: type[Exception] = TimeoutError
        self._exposure_s: float | None = None

    def open(self) -> list[str]:
        """Open the camera by serial number or index. Raises UserError."""
        try:
            from genicam.gentl import TimeoutException
            from harvesters.core import Harvester
        except ImportError:
            raise missing_package(
                "genicam", "harvesters", "pip install 'stillarm[genicam]' (needs CPython 3.9 to 3.13)"
            ) from None
        self.close()
        self._timeout = TimeoutException
        producer = Path(self._config.producer).expanduser()
        if not self._config.producer or not producer.is_file():
            raise UserError(
                f"camera.producer = {self._config.producer!r}: no such file; name the .cti of the camera's maker "
                "(it comes with their software; GENICAM_GENTL64_PATH often says where)"
            )
        self._harvester = Harvester()
        self._harvester.add_file(str(producer))
        self._harvester.update()
        found = self._harvester.device_info_list
        serials = [str(getattr(info, "serial_number", "")) for info in found]
        place = chosen(self._config, serials)
        if place is None:
            self.close()
            raise no_camera(
                self._config, serials, "check its cable and power, or correct the number or camera.producer"
            )
        try:
            self._acquirer = self._harvester.create(place)
        except Exception as error:  # harvesters passes on any exception of the vendor's library
            self.close()
            text = " ".join(str(error).split())
            raise no_camera(
                self._config, serials, f"it cannot be opened ({text}); close what else uses it"
            ) from None
        features = _features(self._acquirer.remote_device.node_map)
        notes = set_features(features, self._config)
        self._exposure_s = exposure_s(features)
        self._acquirer.num_buffers = max(2, self._config.buffers or BUFFERS)
        self._acquirer.start()
        return notes

    def grab(self, timeout_s: float) -> Grab | None:
        """The next image in order of arrival. Raises BackendLost if the transport layer fails."""
        if self._acquirer is None:
            raise BackendLost
        try:
            with self._acquirer.fetch(timeout=max(timeout_s, 0.001)) as buffer:
                component = buffer.payload.components[0]
                image = _image(component)
                return Grab(
                    image,
                    _optional(buffer, "frame_id"),
                    _stamp_s(buffer),
                    self._exposure_s,
                    image is not None,
                )
        except self._timeout:
            return None
        except Exception:  # any exception of the vendor's library: the camera is reopened
            raise BackendLost from None

    def trigger(self) -> None:
        """Expose once."""
        if self._acquirer is not None:
            self._acquirer.remote_device.node_map.TriggerSoftware.execute()

    def close(self) -> None:
        """Release camera and transport layer; may be called twice."""
        acquirer, harvester = self._acquirer, self._harvester
        self._acquirer = self._harvester = None
        if acquirer is not None:
            acquirer.stop()
            acquirer.destroy()
        if harvester is not None:
            harvester.reset()


def _features(node_map: Any) -> NodeFeatures:
    """The features of a GenApi node map, which has an exception type for each kind of refusal."""

    def put(name: str, value: float | str | bool) -> None:
        node = getattr(node_map, name)
        node.value = round(value) if isinstance(value, float) and isinstance(node.value, int) else value

    return NodeFeatures(put, lambda name: getattr(node_map, name).value, (Exception,))


def _image(component: Any) -> Any:
    """A copy of the pixels, since the buffer returns to the camera."""
    width, height, data = component.width, component.height, component.data
    channels, rest = divmod(data.size, width * height)
    if rest or channels not in _CHANNELS:
        return None
    shape = (height, width) if channels == 1 else (height, width, channels)
    return np.array(data.reshape(shape))


def _optional(buffer: Any, name: str) -> int | None:
    try:
        return int(getattr(buffer, name))
    except Exception:  # NotAvailableException and others of the vendor's
        return None


def _stamp_s(buffer: Any) -> float | None:
    nanoseconds = _optional(buffer, "timestamp_ns")
    return nanoseconds * 1e-9 if nanoseconds else None
