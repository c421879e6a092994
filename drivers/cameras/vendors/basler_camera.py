"""Basler's cameras, and others that pylon supports, through pypylon; with PYLON_CAMEMU=1, pylon's emulator."""

from typing import Any

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

_TRIGGER_WAIT_MS = 50
_NO_BLOCK_ID = 2**64 - 1
_TICKS_PER_S = 1e9  # of USB cameras, and of GigE cameras that do not state another rate


class BaslerBackend:
    """stillarm.drivers.cameras.vendors.stream_camera.Backend for pypylon."""

    reference = StampReference.EXPOSURE_START
    counter_modulus = 65535  # GigE Vision's block number: 1 to 65535, then 1 again

    def __init__(self, config: CameraDevice) -> None:
        """Opens nothing."""
        self._config = config
        self._pylon: Any = None
        self._camera: Any = None
        self._exposure_s: float | None = None
        self._ticks_per_s = _TICKS_PER_S

    def open(self) -> list[str]:
        """Open the camera by serial number or index. Raises UserError."""
        try:
            from pypylon import genicam, pylon
        except ImportError:
            raise missing_package(
                "basler", "pypylon", "pip install 'stillarm[basler]' (240 MB, Basler's licence)"
            ) from None
        self.close()
        self._pylon, self._error = pylon, genicam.GenericException
        factory = pylon.TlFactory.GetInstance()
        devices = factory.EnumerateDevices()
        serials = [device.GetSerialNumber() for device in devices]
        place = chosen(self._config, serials)
        if place is None:
            raise no_camera(
                self._config,
                serials,
                "check its cable and power (pylon Viewer shows it), or correct the number",
            )
        try:
            camera = pylon.InstantCamera(factory.CreateDevice(devices[place]))
            camera.Open()
        except self._error as error:
            text = " ".join(str(error).split())
            raise no_camera(
                self._config, serials, f"it cannot be opened ({text}); close what else uses it"
            ) from None
        self._camera = camera
        features = _features(camera.GetNodeMap(), self._error)
        notes = set_features(features, self._config)
        self._exposure_s = exposure_s(features)
        self._ticks_per_s = features.number("GevTimestampTickFrequency") or _TICKS_PER_S
        camera.MaxNumBuffer.Value = max(2, self._config.buffers or BUFFERS)
        camera.StartGrabbing(pylon.GrabStrategy_OneByOne)
        return notes

    def grab(self, timeout_s: float) -> Grab | None:
        """The next image in order of arrival. Raises BackendLost if the camera is gone."""
        if self._camera is None:
            raise BackendLost
        try:
            result = self._camera.RetrieveResult(
                max(1, round(timeout_s * 1e3)), self._pylon.TimeoutHandling_Return
            )
            if not result.IsValid():
                if self._camera.IsCameraDeviceRemoved():
                    raise BackendLost
                return None
            try:
                if not result.GrabSucceeded():
                    return Grab(None, whole=False)
                block, ticks = result.BlockID, result.TimeStamp
                return Grab(
                    result.Array,
                    None if block == _NO_BLOCK_ID else int(block),
                    ticks / self._ticks_per_s if ticks else None,
                    self._exposure_s,
                )
            finally:
                result.Release()
        except self._error:
            raise BackendLost from None

    def trigger(self) -> None:
        """Expose once."""
        camera = self._camera
        if camera is None:
            return
        try:
            if camera.WaitForFrameTriggerReady(_TRIGGER_WAIT_MS, self._pylon.TimeoutHandling_Return):
                camera.ExecuteSoftwareTrigger()
        except self._error:  # gone: the next grab reports it
            return

    def close(self) -> None:
        """Release the camera; may be called twice."""
        camera, self._camera = self._camera, None
        if camera is not None:
            try:
                camera.StopGrabbing()
                camera.Close()
            except self._error:  # already gone
                return


def _features(node_map: Any, error: type[Exception]) -> NodeFeatures:
    """The camera's features in pylon's node map."""
    return NodeFeatures(
        lambda name, value: node_map.GetNode(name).SetValue(value),
        lambda name: node_map.GetNode(name).GetValue(),
        (AttributeError, TypeError, ValueError, error),  # AttributeError: there is no such node
    )
