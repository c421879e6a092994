"""IDS's uEye+ cameras through ids_peak, which needs IDS peak's transport layer besides the Python packages."""

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

_REMEDY = "install IDS peak, then pip install 'stillarm[ids_peak]'"


class IdsPeakBackend:
    """stillarm.drivers.cameras.vendors.stream_camera.Backend for ids_peak."""

    reference = StampReference.EXPOSURE_START
    counter_modulus = 65535

    def __init__(self, config: CameraDevice) -> None:
        """Opens nothing."""
        self._config = config
        self._peak: Any = None
        self._device: Any = None
        self._stream: Any = None
        self._nodes: Any = None
        self._exposure_s: float | None = None

    def open(self) -> list[str]:
        """Open the camera by serial number or index. Raises UserError."""
        try:
            from ids_peak import ids_peak
        except ImportError:
            raise missing_package("ids_peak", "ids_peak", _REMEDY) from None
        self.close()
        self._peak = ids_peak
        try:
            ids_peak.Library.Initialize()
            manager = ids_peak.DeviceManager.Instance()
            manager.Update()
        except ids_peak.Exception:
            raise missing_package("ids_peak", "IDS peak's transport layer", _REMEDY) from None
        devices = list(manager.Devices())
        serials = [str(device.SerialNumber()) for device in devices]
        place = chosen(self._config, serials)
        if place is None:
            raise no_camera(
                self._config,
                serials,
                "check its cable and power (IDS peak Cockpit shows it), or correct the number",
            )
        try:
            self._device = devices[place].OpenDevice(ids_peak.DeviceAccessType_Control)
            self._nodes = self._device.RemoteDevice().NodeMaps()[0]
            features = _features(self._nodes, ids_peak.Exception)
            notes = set_features(features, self._config)
            self._exposure_s = exposure_s(features)
            self._stream = self._device.DataStreams()[0].OpenDataStream()
            payload = self._nodes.FindNode("PayloadSize").Value()
            wanted = max(self._config.buffers or BUFFERS, self._stream.NumBuffersAnnouncedMinRequired())
            for _ in range(wanted):
                self._stream.QueueBuffer(self._stream.AllocAndAnnounceBuffer(payload))
            self._stream.StartAcquisition()
            self._nodes.FindNode("AcquisitionStart").Execute()
        except ids_peak.Exception as error:
            self.close()
            text = " ".join(str(error).split())
            raise no_camera(
                self._config, serials, f"it cannot be opened ({text}); close what else uses it"
            ) from None
        return notes

    def grab(self, timeout_s: float) -> Grab | None:
        """The next image in order of arrival. Raises BackendLost if the camera is gone."""
        if self._stream is None:
            raise BackendLost
        peak = self._peak
        try:
            buffer = self._stream.WaitForFinishedBuffer(peak.Timeout(max(1, round(timeout_s * 1e3))))
        except peak.TimeoutException:
            return None
        except peak.Exception:
            raise BackendLost from None
        try:
            if buffer.IsIncomplete():
                return Grab(None, whole=False)
            width, height = buffer.Width(), buffer.Height()
            image = _grey(peak, buffer, width, height)
            stamp_ns = buffer.Timestamp_ns()
            return Grab(
                image,
                int(buffer.FrameID()),
                stamp_ns * 1e-9 if stamp_ns else None,
                self._exposure_s,
                image is not None,
            )
        finally:
            self._stream.QueueBuffer(buffer)

    def trigger(self) -> None:
        """Expose once."""
        if self._nodes is not None:
            self._nodes.FindNode("TriggerSoftware").Execute()

    def close(self) -> None:
        """Release the camera; may be called twice."""
        stream, self._stream, self._device, self._nodes = self._stream, None, None, None
        if stream is not None:
            try:
                stream.StopAcquisition(self._peak.AcquisitionStopMode_Default)
                stream.Flush(self._peak.DataStreamFlushMode_DiscardAll)
                for buffer in stream.AnnouncedBuffers():
                    stream.RevokeBuffer(buffer)
            except self._peak.Exception:  # already gone
                return


def _features(nodes: Any, error: type[Exception]) -> NodeFeatures:
    """The camera's features in ids_peak's node map; enumeration entries by name."""

    def put(name: str, value: float | str | bool) -> None:
        node = nodes.FindNode(name)
        (node.SetCurrentEntry if isinstance(value, str) else node.SetValue)(value)

    def get(name: str) -> Any:
        return nodes.FindNode(name).Value()

    return NodeFeatures(put, get, (AttributeError, TypeError, ValueError, error))


def _grey(peak: Any, buffer: Any, width: int, height: int) -> Any:
    """A copy of the pixels of an 8-bit grey buffer, since the buffer returns to the camera."""
    size = buffer.Size()
    if size < width * height:
        return None
    from ids_peak import ids_peak_ipl_extension

    image = ids_peak_ipl_extension.BufferToImage(buffer)
    return np.array(image.get_numpy())
