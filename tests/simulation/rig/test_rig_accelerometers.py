"""The rig as a process, presenting itself through accelerometers of each kind; the driver in this one reads it."""

import os
import signal
import subprocess
import sys
import time
from math import isfinite
from pathlib import Path

import pytest

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.common.link.free_ports import free_ports
from stillarm.drivers.accelerometers.accelerometer import SampleStatus
from stillarm.drivers.accelerometers.accelerometer_factory import open_accelerometer

pytestmark = pytest.mark.realtime


@pytest.mark.blind(each_run=2)
@pytest.mark.parametrize("name", ["lis3dh", "adxl355", "icm20948", "witmotion", "xsens", "microcontroller"])
def test_the_driver_reads_the_rig_s_emulated_device(tmp_path: Path, name: str) -> None:
    """At rest: noise about zero along the arm, gravity across, and samples that go on coming."""
    place = f"test-rig-{os.getpid()}-{name}"
    (tmp_path / "model.toml").write_text("[arm]\nlength_m = 2.0\n[accelerometer]\nnoise_std_m_s2 = 0.1\n")
    path = tmp_path / "rig.toml"
    path.write_text(
        f'[accelerometer]\nbus = "memory:{place}"\nport = "pty:{place}"\n'
        f'[camera]\ndriver = "shared_memory"\ndevice = "{place}-camera"\n'
        f"[drive]\ngateway_port = {free_ports(1)[0]}\n"
    )
    command = [sys.executable, "-m", "stillarm", "rig", "--config", str(path), "--accelerometer", name]
    rig = subprocess.Popen(command, stderr=subprocess.PIPE, cwd=Path(__file__).parents[3])
    driver = open_accelerometer(
        AccelerometerDevice(driver=name, bus=f"memory:{place}", port=f"pty:{place}"),  # type: ignore[arg-type]
        wait_s=30.0,
    )
    assert driver is not None
    try:
        driver.start()
        values, gravities = [], []
        give_up = time.monotonic() + 120.0
        while len(values) < 100 and time.monotonic() < give_up:
            value = driver.read()
            reading = driver.last_reading()
            if reading.status == SampleStatus.FRESH:
                values.append(value)
                gravities.append(reading.acceleration_xyz_m_s2[2])
            time.sleep(0.0005)
        assert len(values) == 100
        assert all(isfinite(value) and abs(value) < 2.0 for value in values)
        assert len(set(values)) > 10
        assert sum(gravities) / 100 == pytest.approx(9.80665, abs=0.1)
    finally:
        driver.close()
        rig.send_signal(signal.SIGTERM)
        _, said = rig.communicate(timeout=120.0)
    assert rig.returncode == 0, said
