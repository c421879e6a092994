"""Each vendor's backend: against the vendor's own emulator where it has one, else against a small fake of its package.

Real packages: pypylon (its camera emulator), harvesters (the test transport layer that comes with genicam), Aravis (its
fake camera). Fakes of this file's own: ids_peak, pyueye, picamera2, with the calls that the backend makes and no more.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from stillarm.common.files.configuration import CameraDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera_factory import BACKENDS, open_camera


@pytest.mark.parametrize("driver", sorted(BACKENDS))
def test_an_absent_package_is_one_line_with_the_remedy(driver, monkeypatch):
    for package in ("pypylon", "harvesters", "harvesters.core", "gi", "ids_peak", "pyueye", "picamera2"):
        monkeypatch.setitem(sys.modules, package, None)
    camera = open_camera(CameraDevice(driver=driver))
    with pytest.raises(UserError, match=rf"^camera\.driver = '{driver}': the package [^\n]*install[^\n]*$"):
        camera.start()


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
