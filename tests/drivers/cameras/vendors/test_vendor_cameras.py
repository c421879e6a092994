"""Each vendor's backend: against the vendor's own emulator where it has one, else against a small fake of its package.

Real packages: pypylon (its camera emulator), harvesters (the test transport layer that comes with genicam), Aravis (its
fake camera). Fakes of this file's own: ids_peak, pyueye, picamera2, with the calls that the backend makes and no more.
"""

import importlib.util
import os
import subprocess
import sys
import types
from itertools import pairwise
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera_factory import BACKENDS, open_camera
from stillarm.drivers.cameras.camera_stamps import StampReference

DIST_PACKAGES = "/usr/lib/python3/dist-packages"


def frames_of(camera, count):
    """The first frames of a camera; patient, for a machine that is busy."""
    camera.start()
    try:
        frames = []
        for _ in range(20 * count):
            frame = camera.read(0.5)
            if frame is not None:
                frames.append(frame)
            if len(frames) == count:
                return frames
        raise AssertionError(f"only {len(frames)} frames came")
    finally:
        camera.close()
        camera.close()


@pytest.mark.parametrize("driver", sorted(BACKENDS))
def test_an_absent_package_is_one_line_with_the_remedy(driver, monkeypatch):
    for package in ("pypylon", "harvesters", "harvesters.core", "gi", "ids_peak", "pyueye", "picamera2"):
        monkeypatch.setitem(sys.modules, package, None)
    camera = open_camera(CameraDevice(driver=driver))
    with pytest.raises(UserError, match=rf"^camera\.driver = '{driver}': the package [^\n]*install[^\n]*$"):
        camera.start()


@pytest.fixture
def emulated_pylon(monkeypatch):
    if importlib.util.find_spec("pypylon") is None:
        pytest.skip("pypylon is not installed")
    monkeypatch.setenv("PYLON_CAMEMU", "1")


def test_basler_s_emulator_streams_with_counters_and_without_stamps(emulated_pylon):
    camera = open_camera(
        CameraDevice(driver="basler", width_px=640, height_px=480, exposure_s=0.005, frame_rate_hz=50.0)
    )
    frames = frames_of(camera, 20)
    assert camera.notes == [] and camera.wrong_counters == 0
    assert frames[0].image.shape == (480, 640) and frames[0].image.dtype == np.uint8
    assert all(after.counter > before.counter for before, after in pairwise(frames))
    assert frames[0].exposure_s == pytest.approx(0.005)
    assert all(frame.stamp_s is None for frame in frames)  # the emulator's are 0


def test_basler_s_emulator_says_what_it_does_not_take(emulated_pylon):
    with pytest.raises(UserError, match=r"camera\.width_px = 9000: camera '0' gives \d+ instead"):
        open_camera(CameraDevice(driver="basler", width_px=9000)).start()
    with pytest.raises(UserError, match=r"camera\.device = '7': no such camera \(found: 0815-0000\)"):
        open_camera(CameraDevice(driver="basler", device="7")).start()


def test_basler_s_emulator_triggered_by_software(emulated_pylon):
    camera = open_camera(CameraDevice(driver="basler", width_px=64, height_px=64, trigger="software"), 2)
    frames = frames_of(camera, 5)
    assert all(after.counter > before.counter for before, after in pairwise(frames))


def test_harvesters_with_the_test_transport_layer():
    spec = importlib.util.find_spec("genicam")
    if spec is None or importlib.util.find_spec("harvesters") is None:
        pytest.skip("harvesters is not installed")
    producer = Path(spec.origin).parent / "viky.cti"
    if not producer.exists():
        pytest.skip("this genicam brings no test transport layer")
    camera = open_camera(CameraDevice(driver="genicam", producer=str(producer), frame_rate_hz=15.0))
    frames = frames_of(camera, 4)
    assert frames[0].image.ndim == 2 and frames[0].stamp_s is None  # it gives none
    assert [f.counter - frames[0].counter for f in frames] == [0, 1, 2, 3]
    assert camera.notes == []
    with pytest.raises(UserError, match=r"^camera\.producer = '/nowhere\.cti': no such file"):
        open_camera(CameraDevice(driver="genicam", producer="/nowhere.cti")).start()


@pytest.fixture
def aravis(monkeypatch):
    """Debian's python3-gi, where its Python is this one's version."""
    if importlib.util.find_spec("gi") is None:
        if not list(Path(DIST_PACKAGES).glob(f"gi/_gi.cpython-3{sys.version_info[1]}*")):
            pytest.skip("python3-gi is not installed for this Python")
        monkeypatch.setattr(sys, "path", [*sys.path, DIST_PACKAGES])
    gi = pytest.importorskip("gi")
    try:
        gi.require_version("Aravis", "0.8")
    except ValueError:
        pytest.skip("gir1.2-aravis-0.8 is not installed")


def test_aravis_s_fake_camera_streams_with_counters_and_stamps(aravis):
    config = CameraDevice(driver="aravis", device="Fake_1", exposure_s=0.004, frame_rate_hz=50.0)
    camera = open_camera(config)
    frames = frames_of(camera, 10)
    assert camera.notes == [] and frames[0].image.shape == (512, 512)
    assert frames[0].exposure_s == pytest.approx(0.004)
    assert all(after.counter > before.counter for before, after in pairwise(frames))
    assert all(after.stamp_s > before.stamp_s for before, after in pairwise(frames))
    with pytest.raises(UserError, match=r"camera\.device = 'Nobody': no such camera \(found: "):
        open_camera(CameraDevice(driver="aravis", device="Nobody")).start()


class PeakError(Exception):
    """ids_peak.Exception."""


class PeakTimeout(PeakError):
    """ids_peak.TimeoutException."""


class Node:
    """A node of ids_peak's map: a float, or an enumeration's entry."""

    def __init__(self, value, low=0.0, high=1e9):
        self.value, self.low, self.high, self.executed = value, low, high, 0

    def Value(self):
        return self.value

    def SetValue(self, value):
        self.value = min(max(value, self.low), self.high)

    def SetCurrentEntry(self, entry):
        self.value = entry

    def Execute(self):
        self.executed += 1


def fake_ids_peak(monkeypatch, buffers, transport=True):
    """Modules ids_peak.ids_peak and its image extension, with one camera that has these buffers ready."""
    nodes = {
        name: Node(value, *bounds)
        for name, value, *bounds in (
            ("Width", 64.0),
            ("Height", 48.0),
            ("ExposureTime", 10000.0, 20.0, 15000.0),
            ("AcquisitionFrameRate", 30.0, 1.0, 60.0),
            ("PayloadSize", 64 * 48),
        )
    }
    for name in ("PixelFormat", "TriggerSelector", "TriggerMode", "TriggerSource"):
        nodes[name] = Node("")
    nodes["AcquisitionStart"] = nodes["TriggerSoftware"] = Node(0)

    class Map:
        def FindNode(self, name):
            if name not in nodes:
                raise PeakError(name)
            return nodes[name]

    stream = types.SimpleNamespace(queued=[], given=list(buffers))
    stream.NumBuffersAnnouncedMinRequired = lambda: 3
    stream.AllocAndAnnounceBuffer = lambda size: size
    stream.QueueBuffer = stream.queued.append
    stream.StartAcquisition = lambda: None
    stream.StopAcquisition = stream.Flush = lambda mode: None
    stream.AnnouncedBuffers = list
    stream.OpenDataStream = lambda: stream

    def wait(timeout):
        if not stream.given:
            raise PeakTimeout
        given = stream.given.pop(0)
        if isinstance(given, Exception):
            raise given
        return given

    stream.WaitForFinishedBuffer = wait
    device = types.SimpleNamespace(
        RemoteDevice=lambda: types.SimpleNamespace(NodeMaps=lambda: [Map()]), DataStreams=lambda: [stream]
    )
    found = types.SimpleNamespace(SerialNumber=lambda: "4103", OpenDevice=lambda access: device)
    peak = types.ModuleType("ids_peak.ids_peak")

    def initialise():
        if not transport:
            raise PeakError("GENICAM_GENTL64_PATH not found")

    peak.Library = types.SimpleNamespace(Initialize=initialise)
    manager = types.SimpleNamespace(Update=lambda: None, Devices=lambda: [found])
    peak.DeviceManager = types.SimpleNamespace(Instance=lambda: manager)
    peak.Exception, peak.TimeoutException, peak.Timeout = PeakError, PeakTimeout, int
    peak.DeviceAccessType_Control = peak.AcquisitionStopMode_Default = 0
    peak.DataStreamFlushMode_DiscardAll = 0
    extension = types.ModuleType("ids_peak.ids_peak_ipl_extension")
    extension.BufferToImage = lambda buffer: types.SimpleNamespace(get_numpy=lambda: buffer.pixels)
    package = types.ModuleType("ids_peak")
    package.ids_peak, package.ids_peak_ipl_extension = peak, extension
    for name, module in (
        ("ids_peak", package),
        ("ids_peak.ids_peak", peak),
        ("ids_peak.ids_peak_ipl_extension", extension),
    ):
        monkeypatch.setitem(sys.modules, name, module)
    return nodes, stream


def peak_buffer(frame, stamp_ns=0, incomplete=False):
    return types.SimpleNamespace(
        pixels=np.full((48, 64), frame, np.uint8),
        IsIncomplete=lambda: incomplete,
        Width=lambda: 64,
        Height=lambda: 48,
        Size=lambda: 64 * 48,
        Timestamp_ns=lambda: stamp_ns,
        FrameID=lambda: frame,
    )


def test_ids_peak_against_a_fake_of_its_package(monkeypatch):
    nodes, stream = fake_ids_peak(
        monkeypatch, [peak_buffer(1, 10**9), peak_buffer(2, incomplete=True), peak_buffer(3, 2 * 10**9)]
    )
    camera = open_camera(
        CameraDevice(driver="ids_peak", device="4103", exposure_s=0.010, frame_rate_hz=200.0)
    )
    camera.start()
    frames = [camera.read(0.1) for _ in range(4)]
    assert [f and f.counter for f in frames] == [1, None, 3, None]
    assert frames[0].stamp_s == pytest.approx(1.005) and frames[0].exposure_s == pytest.approx(0.010)
    assert camera.notes == [
        "camera.frame_rate_hz = 200: the camera took 60 instead; set that, or 0 for its default"
    ]
    assert nodes["TriggerMode"].value == "Off" and len(stream.queued) == 4 + 3  # each buffer goes back
    stream.given = [PeakError("device lost")]
    assert camera.read(0.1) is None
    camera.close()


def test_ids_peak_without_its_transport_layer(monkeypatch):
    fake_ids_peak(monkeypatch, [], transport=False)
    with pytest.raises(UserError, match=r"IDS peak's transport layer is not installed; install IDS peak"):
        open_camera(CameraDevice(driver="ids_peak")).start()


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


def fake_picamera2(monkeypatch, frames):
    """A module picamera2 with one camera that has these frames ready: their metadata, or an exception."""

    class Picamera2:
        given: ClassVar = list(frames)
        controls: ClassVar = {}
        closed = 0

        @staticmethod
        def global_camera_info():
            return [{"Model": "imx296"}]

        def __init__(self, number):
            self.number = number

        def create_video_configuration(self, main, controls, buffer_count, queue):
            Picamera2.controls = controls
            return {"main": {"size": (64, 48)}}

        def configure(self, configuration):
            self.configuration = configuration

        def camera_configuration(self):
            return self.configuration

        def start(self):
            pass

        stop = start

        def close(self):
            Picamera2.closed += 1

        def capture_request(self, wait):
            if not self.given:
                raise TimeoutError
            given = self.given.pop(0)
            if isinstance(given, Exception):
                raise given
            return types.SimpleNamespace(
                get_metadata=lambda: given,
                make_array=lambda name: np.full((72, 64), 5, np.uint8),
                release=lambda: None,
            )

    module = types.ModuleType("picamera2")
    module.Picamera2 = Picamera2
    monkeypatch.setitem(sys.modules, "picamera2", module)
    return Picamera2


def test_libcamera_against_a_fake_of_picamera2(monkeypatch):
    metadata = {"SensorTimestamp": 5 * 10**9, "ExposureTime": 8000}
    fake = fake_picamera2(monkeypatch, [metadata, {}, RuntimeError("camera gone")])
    config = CameraDevice(driver="libcamera", exposure_s=0.008, frame_rate_hz=60.0, gain=2.0)
    camera = open_camera(config)
    camera.start()
    assert fake.controls == {
        "AeEnable": False,
        "ExposureTime": 8000,
        "AnalogueGain": 2.0,
        "FrameDurationLimits": (16667, 16667),
    }
    first, second, third = (camera.read(0.1) for _ in range(3))
    assert first.image.shape == (48, 64) and first.stamp_s == pytest.approx(5.004)
    assert first.counter is None and first.exposure_s == pytest.approx(0.008)
    assert second.stamp_s is None and second.exposure_s is None
    assert third is None and fake.closed == 1


@pytest.mark.parametrize(
    ("config", "words"),
    [
        (
            CameraDevice(driver="libcamera", device="3"),
            r"camera\.device = '3': no such camera \(found: imx296\)",
        ),
        (
            CameraDevice(driver="libcamera", trigger="line"),
            r"camera\.trigger = 'line': libcamera has no trigger",
        ),
        (
            CameraDevice(driver="libcamera", width_px=800, height_px=600),
            r"camera\.width_px = 800: [^\n]*64x48",
        ),
    ],
)
def test_what_libcamera_does_not_have(monkeypatch, config, words):
    fake_picamera2(monkeypatch, [])
    with pytest.raises(UserError, match=words):
        open_camera(config).start()


@pytest.mark.slow
def test_no_vendor_s_package_is_imported_before_it_is_named():
    code = (
        "import sys; import stillarm.drivers.cameras.camera_factory, stillarm.drivers.drives.drive_factory\n"
        "import stillarm.supervisor.daemon, stillarm.controller.loop.daemon\n"
        "vendors = 'pypylon harvesters gi ids_peak pyueye picamera2 can canopen'.split()\n"
        "print([name for name in vendors if name in sys.modules])"
    )
    out = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        cwd=Path(__file__).parents[4],
        env={**os.environ, "PYTHONPATH": "."},
    )
    assert out.stdout.strip() == "[]"
