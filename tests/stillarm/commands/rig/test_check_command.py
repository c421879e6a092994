"""`stillarm check` against a rig that runs: it passes, moves nothing, and tells what is wrong with a configuration."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from stillarm.common.link.free_ports import free_ports
from stillarm.common.recording.reader import open_recording
from stillarm.preflight import walk
from stillarm.preflight.verdict import Level
from tests.fixtures.imports import ROOT

CONFIG = """
model = "model.toml"
[link]
controller_port = {ports[0]}
supervisor_port = {ports[1]}
reference_port = {ports[2]}
[supervisor]
cycles_in_flight = 4
[accelerometer]
bus = "memory:{name}-i2c"
[camera]
driver = "shared_memory"
device = "{name}-camera"
[drive]
gateway_port = {ports[3]}
local_port = {ports[4]}
[telemetry]
enabled = false
"""


def stillarm(*words: str) -> list[str]:
    return [sys.executable, "-P", "-m", "stillarm", *words]


@pytest.mark.realtime
def test_a_running_rig_passes_and_a_mistake_is_named(tmp_path: Path) -> None:
    name = f"check-{os.getpid()}"
    (tmp_path / "model.toml").write_text((ROOT / "configs" / "model.toml").read_text())
    good, bad = tmp_path / "rig.toml", tmp_path / "mistake.toml"
    text = CONFIG.format(name=name, ports=free_ports(5))
    good.write_text(text)
    bad.write_text(text.replace(f'"memory:{name}-i2c"', f'"memory:{name}-i2c"\naxis = "z"'))
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    truth = tmp_path / "truth.mcap"
    rig = subprocess.Popen(stillarm("rig", "--config", str(good), "--truth", str(truth)), env=environment)
    try:
        until = time.monotonic() + 120.0
        while not Path(f"/dev/shm/stillarm-{name}-camera").exists() and time.monotonic() < until:
            time.sleep(0.05)
        runs = [
            subprocess.run(
                stillarm("check", "--config", str(path)),
                capture_output=True,
                text=True,
                timeout=180,
                env=environment,
                check=False,
            )
            for path in (good, bad)
        ]
    finally:
        rig.send_signal(signal.SIGTERM)
        rig.wait(120)
    passed, failed = runs
    assert passed.returncode == 0, passed.stdout + passed.stderr
    assert passed.stdout.splitlines()[-1].endswith("0 failed: ready")
    assert [line.split()[0] for line in passed.stdout.splitlines()[:-1]] == sorted(
        (line.split()[0] for line in passed.stdout.splitlines()[:-1]),
        key=["machine", "bus", "sensor", "camera", "link", "drive"].index,
    )
    assert failed.returncode == 1
    failures = [line for line in failed.stdout.splitlines() if "FAIL" in line]
    assert len(failures) == 1, failed.stdout
    assert "accelerometer.axis = 'z' carries" in failures[0]
    position = open_recording(truth).columns("/truth/state")["joint_position_rad"]
    assert (position == 0.0).all()  # nothing moved


def test_nothing_is_touched_while_a_controller_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import socket

    def never(*arguments: object, **named: object) -> None:
        raise AssertionError("touched")

    for name in ("look_at_sensor", "look_at_drive", "look_at_camera", "ask_itself"):
        monkeypatch.setattr(walk, name, never)
    (tmp_path / "model.toml").write_text((ROOT / "configs" / "model.toml").read_text())
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as controller,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as supervisor,
    ):
        for held in (controller, supervisor):
            held.bind(("127.0.0.1", 0))
        ports = [controller.getsockname()[1], supervisor.getsockname()[1], *free_ports(3)]
        path = tmp_path / "rig.toml"
        path.write_text(CONFIG.format(name="check-nobody", ports=ports))
        verdicts = list(walk.walk(path))
    assert [v.where for v in verdicts if v.level == Level.FAIL] == ["link"]
    assert any("does a controller run? stop it" in v.text for v in verdicts)
