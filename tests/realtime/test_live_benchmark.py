"""One real run of the live benchmark: the contract's names, a run that begins with cycle 0, and nothing left behind."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from stillarm.common.recording.reader import open_recording

pytestmark = pytest.mark.realtime

ROOT = Path(__file__).parents[2]
CONTRACT = {
    "run", "seed", "method", "error_mean", "error_max", "delay_rms_s", "delay_normalised_error_squared_max",
    "deflection_normalised_error_squared_max", "settling_time_damped_s", "frames", "frames_lost", "deadline_misses",
    "floor_deadline_misses",
}  # fmt: skip


@pytest.mark.blind(each_run=2, group="long runs of the real processes")
def test_a_run_gives_the_rows_of_the_contract_and_starts_when_all_is_warm(tmp_path: Path) -> None:
    """No figure of this machine is judged, but that the stack started as one: cycle 0 first, an image soon after."""
    words = [
        *("benchmark", "live", "--runs", "1", "--load", "1", "--seed", "3", "--duration-s", "12"),
        *("--methods", "timestamps,fused", "--json", str(tmp_path / "live.json")),
        *("--keep", str(tmp_path / "kept"), "--out", str(tmp_path / "out")),
    ]
    done = subprocess.run(
        [sys.executable, "-P", "-m", "stillarm", *words],
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
        env={"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin"},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    result = json.loads((tmp_path / "live.json").read_text())
    assert result["load"] == 1 and [row["method"] for row in result["rows"]] == ["timestamps", "fused"]
    for row in result["rows"]:
        assert set(row) >= CONTRACT
        assert row["seed"] == 3 and row["cycles"] > 6000 and row["floor_cycles"] > 6000
        assert row["commands_beyond_limits"] == row["commands_without_grounds"] == 0
    assert (tmp_path / "out" / "live.png").exists()
    recording = open_recording(tmp_path / "kept" / "run_0" / "recording.mcap")
    assert recording.columns("/fast")["time_s"][0] < 0.5
    assert recording.columns("/frames")["received_s"][0] < 1.0


@pytest.mark.blind(each_run=2, group="long runs of the real processes")
def test_a_killed_supervisor_is_replaced_and_what_follows_is_scored(tmp_path: Path) -> None:
    """The gap has the requested length, up to the time to start a process; the successor is recognised as a
    new supervisor.
    """
    words = [
        *("benchmark", "live", "--kill-supervisor", "0.5", "--runs", "1", "--seed", "3"),
        *("--json", str(tmp_path / "kills.json"), "--keep", str(tmp_path / "kept")),
    ]
    done = subprocess.run(
        [sys.executable, "-P", "-m", "stillarm", *words],
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
        env={"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin"},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    (row,) = json.loads((tmp_path / "kills.json").read_text())["rows"]
    assert row["method"] == "fused" and row["gap_asked_s"] == 0.5 and 0.3 < row["gap_s"] < 3.0
    frames = open_recording(tmp_path / "kept" / "run_0" / "recording.mcap").columns("/frames")
    assert int(sum(frames["restarted"])) == 1
    assert row["settled_s"] is not None and row["error_mean"] is not None
