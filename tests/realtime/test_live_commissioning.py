"""`stillarm commission` on the simulated rig in real time, interrupted while the joint moves: it comes to rest.

Nothing here waits for a deadline; what is asserted is what was done in the end.
"""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
import pytest
import tomli_w

from stillarm.common.files.configuration import Configuration
from stillarm.common.memory.shared_memory import block_path
from stillarm.common.recording.reader import open_recording
from stillarm.simulation.demo.set_up import write_demo_configuration

pytestmark = pytest.mark.realtime


def start(folder: Path, name: str, *words: str) -> subprocess.Popen[bytes]:
    log = (folder / f"{name}.log").open("ab")
    return subprocess.Popen([sys.executable, "-m", "stillarm", name, *words], stdout=log, stderr=log)


def wait_until(condition: object, seconds: float = 150.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():  # type: ignore[operator]
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[tuple[Path, Configuration]]:
    """The rig, untouched, and its supervisor."""
    path, configuration, _ = write_demo_configuration(tmp_path, 20.0, 4)
    replace = msgspec.structs.replace
    configuration = replace(configuration, controller=replace(configuration.controller, schedule=""))
    path.write_text(tomli_w.dumps(msgspec.to_builtins(configuration)))
    words = ("--config", str(path))
    running = [start(tmp_path, "rig", *words, "--scenario", "quiet", "--truth", str(tmp_path / "truth.mcap"))]
    wait_until(lambda: block_path(configuration.camera.device).exists())
    running.append(start(tmp_path, "supervisor", *words))
    try:
        yield path, configuration
    finally:
        for process in reversed(running):
            process.send_signal(signal.SIGTERM)
            process.wait(20.0)


def commission(path: Path) -> subprocess.Popen[bytes]:
    """Started, and seen to record for longer than the rest at its beginning."""
    folder = path.parent
    words = ("--config", str(path), "-o", str(folder / "found.toml"), "--yes", "--allow-non-realtime")
    process = start(folder, "commission", *words)
    recording = folder / "commissioning" / "probe.mcap"
    wait_until(recording.exists)
    time.sleep(9.0)
    if process.poll() is not None:
        skip_where_images_starve(folder)
    assert process.poll() is None
    return process


def skip_where_images_starve(folder: Path) -> None:
    """The watch ends the moves by itself then, as it must, and there is nothing left to interrupt."""
    if "no image was measured" in (folder / "commission.log").read_text():
        pytest.skip("this machine is too busy to track images")


@pytest.mark.parametrize("how", ["interrupt", "stop"])
def test_an_interruption_leaves_the_joint_still(rig: tuple[Path, Configuration], how: str) -> None:
    """Ctrl-C, or the operator's emergency stop: the command ends, one line says so, no model is written."""
    path, _ = rig
    process = commission(path)
    if how == "interrupt":
        process.send_signal(signal.SIGINT)
    else:
        words = ["operate", "stop", "--config", str(path)]
        subprocess.run([sys.executable, "-m", "stillarm", *words], check=False, capture_output=True)
    status = process.wait(60.0)
    skip_where_images_starve(path.parent)
    assert status == (130 if how == "interrupt" else 1)
    said = (path.parent / "commission.log").read_text().strip().splitlines()[-1]
    assert "interrupted" in said if how == "interrupt" else "emergency stop" in said
    assert "Traceback" not in said and not (path.parent / "found.toml").exists()
    time.sleep(1.0)
    recorded = open_recording(path.parent / "commissioning" / "probe.mcap").columns("/fast")
    command, position = recorded["joint_velocity_command_rad_s"], recorded["joint_position_rad"]
    assert np.nanmax(np.abs(command)) > 0.003 and command[-1] == 0.0
    assert np.nanmax(np.abs(position)) < 0.06
