"""uEye's backend against a fake of its package."""

import sys
import types

import numpy as np
import pytest

from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera_factory import open_camera
from stillarm.drivers.cameras.camera_stamps import StampReference


def fake_ueye(monkeypatch, sensor, images, present=True):
    """A module pyueye.ueye with one camera of this sensor that has these images ready: (code, frame, ticks)."""
    ueye = types.ModuleType("pyueye.ueye")
    ueye.calls, ueye.given = [], list(images)
    for number, name in enumerate(
        [
            "IS_CM_MONO8",
            "IS_AOI_IMAGE_SET_AOI",
            "IS_SET_TRIGGER_OFF",
            "IS_SET_TRIGGER_SOFTWARE",
            "IS_SET_TRIGGER_LO_HI",
            "IS_DONT_WAIT",
            "IS_EXPOSURE_CMD_SET_EXPOSURE",
            "IS_EXPOSURE_CMD_GET_EXPOSURE",
            "IS_IGNORE_PARAMETER",
            "IS_FORCE_VIDEO_STOP",
            "IS_CAPTURE_STATUS_INFO_CMD_RESET",
        ]
    ):
        setattr(ueye, name, number)
    ueye.IS_SUCCESS, ueye.IS_TIMED_OUT, ueye.IS_CAPTURE_STATUS = 0, 122, 162

    class Number:
        def __init__(self, value=0):
            self.value = value

    ueye.HIDS = ueye.INT = ueye.double = Number
    ueye.c_mem_p = Number
    ueye.sizeof = lambda thing: 8
    ueye.SENSORINFO = ueye.UEYEIMAGEINFO = ueye.IS_RECT = types.SimpleNamespace

    def wait(camera, timeout, memory, number):
        code, ueye.frame, ueye.ticks = ueye.given.pop(0) if ueye.given else (122, 0, 0)
        return code

    def sensor_info(camera, info):
        info.strSensorName, info.nMaxWidth, info.nMaxHeight = sensor, 64, 48

    def image_info(camera, number, info, size):
        info.u64FrameNumber, info.u64TimestampDevice = ueye.frame, ueye.ticks
        return 0

    def frame_rate(camera, wanted, given):
        given.value = min(wanted.value, 87.0)

    ueye.is_WaitForNextImage, ueye.is_GetSensorInfo = wait, sensor_info
    ueye.is_GetImageInfo, ueye.is_SetFrameRate = image_info, frame_rate
    ueye.get_data = lambda memory, width, height, bits, pitch, copy: np.full(width * height, 9, np.uint8)
    ueye.is_InitCamera = lambda camera, window: 0 if present else 3
    for name in [
        "is_SetColorMode",
        "is_AOI",
        "is_AllocImageMem",
        "is_AddToSequence",
        "is_InitImageQueue",
        "is_SetExternalTrigger",
        "is_CaptureVideo",
        "is_Exposure",
        "is_SetHardwareGain",
        "is_UnlockSeqBuf",
        "is_StopLiveVideo",
        "is_ExitImageQueue",
        "is_ClearSequence",
        "is_FreeImageMem",
        "is_ExitCamera",
        "is_CaptureStatus",
        "is_ForceTrigger",
    ]:
        setattr(ueye, name, lambda *a, _name=name: ueye.calls.append(_name) or 0)
    package = types.ModuleType("pyueye")
    package.ueye = ueye
    monkeypatch.setitem(sys.modules, "pyueye", package)
    monkeypatch.setitem(sys.modules, "pyueye.ueye", ueye)
    return ueye


@pytest.mark.parametrize(
    ("sensor", "reference"),
    [
        (b"UI122xLE-M\0", StampReference.TRANSFER_END),
        (b"UI324xCP-M\0", StampReference.EXPOSURE_END),
        (b"UI524xRE-M\0", StampReference.EXPOSURE_END),
    ],
)
def test_ueye_against_a_fake_of_its_package(monkeypatch, sensor, reference):
    ueye = fake_ueye(monkeypatch, sensor, [(0, 7, 10**7), (162, 0, 0), (0, 9, 2 * 10**7), (122, 0, 0)])
    camera = open_camera(CameraDevice(driver="ueye", exposure_s=0.010, frame_rate_hz=100.0))
    camera.start()
    frames = [camera.read(0.1) for _ in range(4)]
    assert [f and f.counter for f in frames] == [7, None, 9, None]
    assert frames[0].stamp_s == pytest.approx(1.0 - 0.005)
    assert camera._backend.reference == reference
    assert camera.notes == [
        "camera.frame_rate_hz = 100: the camera took 87 instead; set that, or 0 for its default"
    ]
    assert ueye.calls.count("is_UnlockSeqBuf") == 2  # each buffer goes back
    ueye.given = [(1, 0, 0)]
    assert camera.read(0.1) is None and "is_ExitCamera" in ueye.calls
    camera.close()
    camera.close()


def test_a_ueye_that_is_not_there(monkeypatch):
    fake_ueye(monkeypatch, b"", [], present=False)
    with pytest.raises(UserError, match=r"camera\.device = '0': no such camera \(none found\); uEye error 3"):
        open_camera(CameraDevice(driver="ueye")).start()
