"""IDS peak's backend against a fake of its package."""

import sys
import types

import numpy as np
import pytest

from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera_factory import open_camera


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
