"""`stillarm commission` on the simulated rig in real time, interrupted while the joint moves: it comes to rest.

Nothing here waits for a deadline; what is asserted is what was done in the end.
"""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from stillarm.common.recording.reader import open_recording
from tests.fixtures.quiet_rig import quiet_rig, start, wait_until

pytestmark = pytest.mark.realtime


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Path]:
    with quiet_rig(tmp_path) as path:
        yield path


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
    said = (folder / "commission.log").read_text()
    if "no image was measured" in said or "this computer is too busy" in said:
        pytest.skip("this machine is too busy to track images")


@pytest.mark.blind(each_run=2, group="long runs of the real processes")
@pytest.mark.parametrize("how", ["interrupt", "stop"])
def test_an_interruption_leaves_the_joint_still(rig: Path, how: str) -> None:
    """Ctrl-C, or the operator's emergency stop: the command ends, one line says so, no model is written."""
    path = rig
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
