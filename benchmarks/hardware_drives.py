"""The cost of each drive and camera, with its emulator; for `stillarm benchmark hardware`.

us_per_cycle is the median processor time of a cycle's command and report in the driver's own thread, without the
emulator's time. us_per_frame is the processor time to read an image, without waiting. rate_hz is the rate reached.
A camera whose package is not installed has no row.
"""

import importlib.util
import os
import sys
import threading
import time
from math import isfinite
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from stillarm.common.files.configuration import CameraDevice, Cia402Device, DriveDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera_factory import open_camera
from stillarm.drivers.drives.drive import Drive
from stillarm.drivers.drives.drive_factory import open_drive
from stillarm.simulation.rig.rig_drive import RigDrive, rig_drive

_KEY = b"the key of the benchmark"
_CYCLES = 2000  # a trial
_WIRE_S = 60e-6  # delivery time of a pseudo terminal and a socket
_FRAMES = 60
_RATE_HZ = 50.0


def drive_rows(trials: int) -> list[dict[str, Any]]:
    """Rows of drive, tested_against, us_per_cycle, us_per_cycle_p99, reports_per_cycle."""
    tested = {
        "udp_gateway": "reference gateway on loopback",
        "odrive": "emulator on a pseudo terminal",
        "cia402": "emulator on python-can's udp_multicast",
        "mcp4725": "emulator on a bus in memory",
    }
    return [_drive_row(driver, against, trials * _CYCLES) for driver, against in tested.items()]


def camera_rows() -> list[dict[str, Any]]:
    """Rows of camera, tested_against, size_px, asked_hz, rate_hz, us_per_frame, counters, stamps."""
    rows = []
    for name, against, device in _cameras():
        try:
            rows.append(_camera_row(name, against, device))
        except UserError:  # not available on this computer
            continue
    return rows


def _drive_row(driver: str, against: str, cycles: int) -> dict[str, Any]:
    place = f"benchmark-{os.getpid()}"
    plain = DriveDevice()
    replace = msgspec.structs.replace
    device = msgspec.convert(
        msgspec.to_builtins(
            replace(
                plain,
                odrive=replace(plain.odrive, port=f"pty:{place}"),
                mcp4725=replace(plain.mcp4725, bus=f"memory:{place}"),
                cia402=Cia402Device(interface="udp_multicast", channel="239.74.163.2", node=111),
                gateway_port=47590,
                local_port=47591,
            )
        )
        | {"driver": driver},
        DriveDevice,
    )
    rig = rig_drive(device, _KEY)
    drive = open_drive(device, _KEY)
    assert drive is not None
    try:
        _start(drive, rig)
        costs = []
        reports = 0
        for _ in range(cycles):
            started = time.thread_time_ns()
            drive.command(0.01)
            position, _, _ = drive.state()
            costs.append((time.thread_time_ns() - started) * 1e-3)
            reports += isfinite(position)
            rig.poll(time.monotonic())
            rig.report(0.1, 0.0)
            time.sleep(_WIRE_S)
    finally:
        drive.close()
        rig.close()
    return {
        "drive": driver,
        "tested_against": against,
        "us_per_cycle": float(np.median(costs)),
        "us_per_cycle_p99": float(np.percentile(costs, 99)),
        "reports_per_cycle": reports / cycles,
    }


def _start(drive: Drive, rig: RigDrive) -> None:
    """Start the drive. Its set-up waits for answers, which the rig gives from a thread."""
    done = threading.Event()

    def answer() -> None:
        while not done.is_set():
            rig.poll(time.monotonic())
            time.sleep(0.0005)

    thread = threading.Thread(target=answer)
    thread.start()
    try:
        drive.start()
    finally:
        done.set()
        thread.join()


def _cameras() -> list[tuple[str, str, CameraDevice]]:
    os.environ.setdefault("PYLON_CAMEMU", "1")
    sys.path.append("/usr/lib/python3/dist-packages")  # where Debian keeps gi
    genicam = importlib.util.find_spec("genicam")
    producer = str(Path(genicam.origin).parent / "viky.cti") if genicam and genicam.origin else ""
    emulated = CameraDevice(
        driver="basler", exposure_s=0.005, width_px=640, height_px=480, frame_rate_hz=_RATE_HZ
    )
    return [
        ("basler", "pylon's camera emulator", emulated),
        (
            "genicam",
            "test transport layer of genicam",
            CameraDevice(driver="genicam", producer=producer, frame_rate_hz=20.0),
        ),
        (
            "aravis",
            "Aravis's fake camera",
            CameraDevice(driver="aravis", device="Fake_1", frame_rate_hz=_RATE_HZ),
        ),
    ]


def _camera_row(name: str, against: str, device: CameraDevice) -> dict[str, Any]:
    camera = open_camera(device)
    camera.start()
    costs, arrived, frames = [], [], []
    try:
        for _ in range(20 * _FRAMES):
            started = time.thread_time_ns()
            frame = camera.read(0.2)
            if frame is None:
                continue
            costs.append((time.thread_time_ns() - started) * 1e-3)
            arrived.append(time.monotonic())
            frames.append((frame.counter, frame.stamp_s))
            height, width = frame.image.shape
            if len(frames) == _FRAMES:
                break
    finally:
        camera.close()
    return {
        "camera": name,
        "tested_against": against,
        "size_px": f"{width}x{height}",
        "asked_hz": device.frame_rate_hz,
        "rate_hz": (len(arrived) - 1) / (arrived[-1] - arrived[0]),
        "us_per_frame": float(np.median(costs)),
        "counters": frames[0][0] is not None,
        "stamps": frames[0][1] is not None,
    }
