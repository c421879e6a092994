"""IDS's older uEye cameras (the paper's among them) through pyueye and the uEye driver (IDS Software Suite 4.9x)."""

from typing import Any

import numpy as np

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

_DEVICE_TICK_S = 1e-7  # of u64TimestampDevice
_BITS = 8
_REMEDY = "install the IDS Software Suite, then pip install 'stillarm[ueye]'"
_TOLERANCE = 0.01  # relative difference from the requested value that is not reported


class UeyeBackend:
    """stillarm.drivers.cameras.vendors.stream_camera.Backend for pyueye."""

    reference = StampReference.TRANSFER_END
    counter_modulus = 0

    def __init__(self, config: CameraDevice) -> None:
        """Opens nothing."""
        self._config = config
        self._ueye: Any = None
        self._camera: Any = None
        self._memories: list[tuple[Any, Any]] = []
        self._shape = (0, 0)
        self._exposure_s: float | None = None

    def open(self) -> list[str]:
        """Open the camera by its device number (0: the first free one). Raises UserError."""
        try:
            from pyueye import ueye
        except (ImportError, RuntimeError, OSError):
            raise missing_package("ueye", "pyueye, or the uEye driver beneath it,", _REMEDY) from None
        self.close()
        self._ueye = ueye
        if not self._config.device.isdigit():
            raise no_camera(
                self._config, [], "give the camera's device number as the IDS Camera Manager shows it, or 0"
            )
        camera = ueye.HIDS(int(self._config.device))
        if (code := ueye.is_InitCamera(camera, None)) != ueye.IS_SUCCESS:
            raise no_camera(
                self._config, [], f"uEye error {code}; check cable and power, close what else uses it"
            )
        self._camera = camera
        info = ueye.SENSORINFO()
        ueye.is_GetSensorInfo(camera, info)
        self.reference = _reference(bytes(info.strSensorName).decode("ascii", "replace"))
        width, height = int(info.nMaxWidth), int(info.nMaxHeight)
        try:
            notes = self._set_up(width, height)
        except UserError:
            self.close()
            raise
        return notes

    def grab(self, timeout_s: float) -> Grab | None:
        """The next image in order of arrival. Raises BackendLost if the camera is gone."""
        ueye, camera = self._ueye, self._camera
        if camera is None:
            raise BackendLost
        memory, number = ueye.c_mem_p(), ueye.INT(0)
        code = ueye.is_WaitForNextImage(camera, max(1, round(timeout_s * 1e3)), memory, number)
        if code == ueye.IS_TIMED_OUT:
            return None
        if code == ueye.IS_CAPTURE_STATUS:  # a transfer failed: the image is lost, the camera is still there
            ueye.is_CaptureStatus(camera, ueye.IS_CAPTURE_STATUS_INFO_CMD_RESET, None, 0)
            return Grab(None, whole=False)
        if code != ueye.IS_SUCCESS:
            raise BackendLost
        try:
            info = ueye.UEYEIMAGEINFO()
            known = ueye.is_GetImageInfo(camera, number, info, ueye.sizeof(info)) == ueye.IS_SUCCESS
            height, width = self._shape
            flat = ueye.get_data(memory, width, height, _BITS, width, copy=True)
            return Grab(
                np.reshape(flat, (height, width)),
                int(info.u64FrameNumber) if known else None,
                int(info.u64TimestampDevice) * _DEVICE_TICK_S if known else None,
                self._exposure_s,
            )
        finally:
            ueye.is_UnlockSeqBuf(camera, number, memory)

    def trigger(self) -> None:
        """Expose once."""
        if self._camera is not None:
            self._ueye.is_ForceTrigger(self._camera)

    def close(self) -> None:
        """Release the camera; may be called twice."""
        camera, self._camera = self._camera, None
        if camera is not None:
            ueye = self._ueye
            ueye.is_StopLiveVideo(camera, ueye.IS_FORCE_VIDEO_STOP)
            ueye.is_ExitImageQueue(camera)
            ueye.is_ClearSequence(camera)
            for memory, number in self._memories:
                ueye.is_FreeImageMem(camera, memory, number)
            self._memories = []
            ueye.is_ExitCamera(camera)

    def _set_up(self, width: int, height: int) -> list[str]:
        ueye, camera, config = self._ueye, self._camera, self._config
        ueye.is_SetColorMode(camera, ueye.IS_CM_MONO8)
        for key, wanted, most in (
            ("width_px", config.width_px, width),
            ("height_px", config.height_px, height),
        ):
            if wanted > most:
                raise UserError(
                    f"camera.{key} = {wanted}: camera {config.device!r} has {most}; set at most that, or 0 for all"
                )
        if config.width_px or config.height_px:
            width, height = config.width_px or width, config.height_px or height
            area = ueye.IS_RECT()
            area.s32X, area.s32Y = ueye.INT(0), ueye.INT(0)
            area.s32Width, area.s32Height = ueye.INT(width), ueye.INT(height)
            if ueye.is_AOI(camera, ueye.IS_AOI_IMAGE_SET_AOI, area, ueye.sizeof(area)) != ueye.IS_SUCCESS:
                raise UserError(
                    f"camera.width_px = {width}, camera.height_px = {height}: camera {config.device!r} refuses this "
                    "image size; try multiples of 16, or 0 for the whole image"
                )
        self._shape = (height, width)
        for _ in range(max(3, config.buffers or BUFFERS)):
            memory, number = ueye.c_mem_p(), ueye.INT(0)
            ueye.is_AllocImageMem(camera, width, height, _BITS, memory, number)
            ueye.is_AddToSequence(camera, memory, number)
            self._memories.append((memory, number))
        ueye.is_InitImageQueue(camera, 0)
        notes = self._set_timing()
        modes = {
            "freerun": ueye.IS_SET_TRIGGER_OFF,
            "software": ueye.IS_SET_TRIGGER_SOFTWARE,
            "line": ueye.IS_SET_TRIGGER_LO_HI,
        }
        ueye.is_SetExternalTrigger(camera, modes[config.trigger])
        ueye.is_CaptureVideo(camera, ueye.IS_DONT_WAIT)
        return notes

    def _set_timing(self) -> list[str]:
        """Set the rate first, since it bounds the exposure."""
        ueye, camera, config = self._ueye, self._camera, self._config
        notes = []
        if config.frame_rate_hz and config.trigger == "freerun":
            given = ueye.double(0.0)
            ueye.is_SetFrameRate(camera, ueye.double(config.frame_rate_hz), given)
            notes += _refusal("frame_rate_hz", config.frame_rate_hz, float(given.value))
        exposure_ms = ueye.double(config.exposure_s * 1e3)
        command = (
            ueye.IS_EXPOSURE_CMD_SET_EXPOSURE if config.exposure_s else ueye.IS_EXPOSURE_CMD_GET_EXPOSURE
        )
        if ueye.is_Exposure(camera, command, exposure_ms, ueye.sizeof(exposure_ms)) == ueye.IS_SUCCESS:
            self._exposure_s = float(exposure_ms.value) * 1e-3 or None
            if config.exposure_s:
                notes += _refusal("exposure_s", config.exposure_s, float(exposure_ms.value) * 1e-3)
        if config.gain >= 0.0:
            gain = min(round(config.gain), 100)
            ignore = ueye.IS_IGNORE_PARAMETER
            if ueye.is_SetHardwareGain(camera, gain, ignore, ignore, ignore) != ueye.IS_SUCCESS:
                notes.append(f"camera.gain = {config.gain:g}: the camera refused it; 0 to 100 is allowed")
        return notes


def _reference(sensor_name: str) -> StampReference:
    """The instant of a stamp by model: UI-1xxx (UI122x...), UI-2xxx are USB 2, UI-3xxx USB 3, UI-5xxx, UI-6xxx GigE."""
    digits = [c for c in sensor_name if c.isdigit()]
    return StampReference.EXPOSURE_END if digits and digits[0] in "3456" else StampReference.TRANSFER_END


def _refusal(key: str, wanted: float, given: float) -> list[str]:
    if abs(given - wanted) <= _TOLERANCE * wanted:
        return []
    return [f"camera.{key} = {wanted:g}: the camera took {given:g} instead; set that, or 0 for its default"]
