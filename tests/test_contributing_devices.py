"""CONTRIBUTING.md's steps for an accelerometer, a camera and a drive, done in a copy of the program.

The devices are invented: docs/examples/devices has them.
"""

import shutil
from pathlib import Path

import pytest

from tests.fixtures.imports import ROOT
from tests.fixtures.program_copy import program, python

__all__ = ["program"]
DEVICES = ROOT / "docs" / "examples" / "devices"

pytestmark = pytest.mark.slow


def insert(program: Path, file: str, *changes: tuple[str, str]) -> None:
    """Put a text before a mark in a file of the copy; each mark is there once."""
    text = (program / file).read_text()
    for mark, added in changes:
        assert text.count(mark) == 1, f"{file}: {mark!r} is there {text.count(mark)} times"
        text = text.replace(mark, f"{added}{mark}")
    (program / file).write_text(text)


def add_files(program: Path, folder: str, *names: str) -> None:
    """Copy examples into a folder of the copy, and name them in its `__all__`."""
    for name in names:
        shutil.copy(DEVICES / name, program / folder / name)
    exports = "".join(f'"{name.removesuffix(".py")}", ' for name in names)
    interface = program / folder / "__init__.py"
    interface.write_text(interface.read_text().replace("__all__ = [", f"__all__ = [{exports}", 1))


def test_an_accelerometer_is_a_table_and_a_chip(program: Path) -> None:
    """The driver reads the emulated part to half a count, in both ranges; the demo offers it."""
    tables, parts = "drivers/accelerometers/register_tables", "drivers/buses/parts.py"
    shutil.copy(DEVICES / "plain16.py", program / tables / "plain16.py")
    insert(
        program,
        f"{tables}/__init__.py",
        (
            "from stillarm.drivers.accelerometers.register_tables.register_table",
            "from stillarm.drivers.accelerometers.register_tables.plain16 import PLAIN16\n",
        ),
        ('    "adxl345": ADXL345,', '    "plain16": PLAIN16,\n'),
    )
    add_files(program, "drivers/emulated_chips", "plain16_chip.py")
    insert(
        program,
        parts,
        (
            "from stillarm.drivers.emulated_chips.register_chip",
            "from stillarm.drivers.emulated_chips.plain16_chip import PLAIN16_CHIP\n",
        ),
        ("LIS3DH_CHIP, ADXL345_CHIP", "PLAIN16_CHIP, "),
    )
    insert(program, "common/files/configuration.py", ('"lis3lv02dq", "lis3dh"', '"plain16", '))
    read = """
import msgspec
from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.drivers.accelerometers.accelerometer_factory import open_accelerometer
from stillarm.drivers.emulation.emulated_accelerometer import emulate_accelerometer, emulated_driver

assert emulated_driver("plain16") == "plain16"
for full_scale_g in (2, 4):
    section = {"driver": "plain16", "bus": "memory:test-contributing", "axis": "y", "full_scale_g": full_scale_g}
    device = msgspec.convert(section, AccelerometerDevice)
    registers, driver = emulate_accelerometer(device, 0.001), open_accelerometer(device, wait_s=0.0)
    driver.start()
    for _ in range(10):
        registers.publish((0.0, 2.9994, 9.8))
        sample = driver.read()
    print(sample)
    driver.close()
    registers.close()
"""
    fine, coarse = map(float, python(program, read).split())
    count = 9.80665 / 16384.0
    assert abs(fine - 2.9994) <= 0.5 * count and abs(coarse - 2.9994) <= count
    assert fine != coarse


PLAINCAM = """
import numpy as np

class Image:
    def __init__(self, number):
        self.pixels = np.full((4, 6), number, dtype=np.uint8)
        self.number, self.stamp_ns, self.exposure_us = (65534 + number) % 65536, 1_000_000 * number, 500.0

class Camera:
    def __init__(self, serial):
        self.number = 0
    def set_exposure(self, exposure_s):
        return 0.0005
    def next(self, timeout_s):
        self.number += 1
        if self.number == 4:
            raise OSError("unplugged")
        return Image(self.number)
    def trigger(self):
        pass
    def close(self):
        pass

def serials():
    return ["A1", "B2"]
"""


def test_a_camera_is_a_backend(program: Path) -> None:
    """Counts go on where the maker's wrap, stamps are at mid-exposure, and a camera that is gone raises nothing."""
    add_files(program, "drivers/cameras/vendors", "plain_camera.py")
    insert(
        program,
        "drivers/cameras/camera_factory.py",
        (
            '    "basler": (',
            '    "plain": ("stillarm.drivers.cameras.vendors.plain_camera", "PlainBackend"),\n',
        ),
    )
    insert(program, "common/files/configuration.py", ('        "basler",\n', '        "plain",\n'))
    grab = """
import msgspec
from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera_factory import open_camera

camera = open_camera(msgspec.convert({"driver": "plain", "device": "B2", "exposure_s": 0.001}, CameraDevice))
try:
    camera.start()
except UserError as error:
    print(error)
else:
    print(camera.notes)
    for _ in range(3):
        frame = camera.read(0.1)
        print(frame.counter, round(frame.stamp_s, 6), frame.image.shape)
    print(camera.read(0.1))
    camera.close()
"""
    missing = "camera.driver = 'plain': the package plaincam is not installed; pip install 'stillarm[plain]'"
    assert python(program, grab).strip() == missing
    (program / "plaincam.py").write_text(PLAINCAM)
    assert python(program, grab).splitlines() == [
        "['camera.exposure_s = 0.001: the camera set 0.0005']",
        "65535 0.00125 (4, 6)",
        "65536 0.00225 (4, 6)",
        "65537 0.00325 (4, 6)",
        "None",
    ]


LINE_DEVICE = '''class LineDevice(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A line drive. port: a serial device, or pty:NAME for an emulator's."""

    port: str = "/dev/ttyUSB0"


'''


def test_a_drive_is_a_driver_and_an_emulator(program: Path) -> None:
    """The joint follows a command by the gear, the report comes back, and both stop when commands cease."""
    add_files(program, "drivers/emulation", "line_motor.py")
    shutil.copy(DEVICES / "line_drive.py", program / "drivers" / "drives" / "line_drive.py")
    insert(
        program,
        "common/files/configuration.py",
        ("class DriveDevice(", LINE_DEVICE),
        ('"udp_gateway", "odrive"', '"line", '),
        ("    odrive: OdriveDevice = ", "    line: LineDevice = LineDevice()\n"),
    )
    odrive = '    if config.driver == "odrive":\n'
    odrive += "        from stillarm.drivers.drives.odrive_drive import OdriveDrive\n\n"
    opened = "from stillarm.drivers.drives.line_drive import LineDrive\n\n        return LineDrive(config)"
    insert(
        program,
        "drivers/drives/drive_factory.py",
        (
            f"{odrive}        return OdriveDrive(config)\n",
            f'    if config.driver == "line":\n        {opened}\n',
        ),
        (
            f"{odrive}        return OdriveDrive(config).probe",
            f'    if config.driver == "line":\n        {opened}.probe(span_s)\n',
        ),
    )
    end = (DEVICES / "line_rig_end.py").read_text()
    insert(
        program,
        "simulation/rig/rig_drive.py",
        (
            "from stillarm.drivers.emulation.odrive_motor",
            "from stillarm.drivers.emulation.line_motor import LineMotor\n",
        ),
        (
            '    if config.driver == "odrive":',
            '    if config.driver == "line":\n        return RigLine(config)\n',
        ),
        ("class RigOdrive:", end[end.index("class RigLine") :] + "\n\n"),
    )
    insert(
        program,
        "simulation/demo/set_up.py",
        ('"udp_gateway", "odrive"', '"line", '),
        ('"odrive": -25.0', '"line": 10.0, '),
    )
    drive = """
import threading, time
import msgspec
from stillarm.common.files.configuration import DriveDevice
from stillarm.drivers.drives.drive_factory import open_drive, probe_drive
from stillarm.simulation.rig.rig_drive import rig_drive

section = {"driver": "line", "gear_ratio": -10.0, "line": {"port": "pty:test-contributing"}}
config = msgspec.convert(section, DriveDevice)
rig = rig_drive(config, b"")
followed, ended = [], threading.Event()

def run():
    while not ended.wait(0.001):
        followed.append(rig.poll(time.monotonic()))
        rig.report(0.25, 0.5)

thread = threading.Thread(target=run)
thread.start()
probe = probe_drive(config, b"", 0.2)
assert probe.reports > 5 and abs(probe.position_rad - 0.25) < 1e-6 and not rig.commanded
drive = open_drive(config, b"")
assert drive.state().age_s == float("inf")
drive.start()
until = time.monotonic() + 60.0
while not (rig.commanded and abs(followed[-1] - 0.2) < 1e-6) and time.monotonic() < until:
    drive.command(0.2)
    time.sleep(0.002)
state = drive.state()
assert abs(followed[-1] - 0.2) < 1e-6 and abs(state.velocity_rad_s - 0.5) < 1e-6, (followed[-1], state)
time.sleep(0.3)
assert followed[-1] == 0.0
drive.command(float("nan"))
ended.set()
thread.join()
rig.close()
time.sleep(0.1)
assert drive.state().age_s > 0.05
drive.close()
drive.close()
print("all")
"""
    assert python(program, drive).strip() == "all"
    assert "line" in python(
        program, "from stillarm.simulation.demo.set_up import EMULATED_DRIVES; print(EMULATED_DRIVES)"
    )
