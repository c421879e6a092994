"""The real processes, in real time: killed, restarted, recorded, replayed.

One run serves all: the supervisor is killed in the middle and started again, the controller is killed at the end. The
arm is struck every 0.7 s with damping on, so that there is always something to command.
"""

import base64
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from stillarm.common.memory.shared_memory import block_path
from stillarm.common.recording.reader import Recording, open_recording
from stillarm.controller.replay.replay import compare_with_live, read_run
from stillarm.simulation.demo.set_up import write_demo_configuration
from stillarm.supervisor.recorded_images import compare_with_live as compare_images

pytestmark = pytest.mark.realtime

STRIKES_S = [0.5 + 0.7 * k for k in range(80)]


@dataclass
class LiveRun:
    """Where the recordings lie, and when what was done, on the controller's clock."""

    folder: Path
    recording: Recording
    killed_s: float
    restarted_s: float
    controller_killed_s: float


def start(name: str, folder: Path, *words: str) -> subprocess.Popen[bytes]:
    log = (folder / f"{name}.log").open("ab")
    return subprocess.Popen([sys.executable, "-m", "stillarm", name, *words], stdout=log, stderr=log)


def wait_until(condition: object, seconds: float) -> None:
    deadline = time.monotonic() + seconds
    while not condition():  # type: ignore[operator]
        assert time.monotonic() < deadline
        time.sleep(0.05)


def times_damping_began(folder: Path) -> int:
    """How often the controller has told that the damping began."""
    return (folder / "controller.log").read_text().count('"event":"damping"')


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveRun]:
    folder = tmp_path_factory.mktemp("live")
    path, configuration, _ = write_demo_configuration(folder, 12.0, 5)
    strikes = ", ".join(f"{{time_s = {t:.1f}, deflection_m = 0.00625}}" for t in STRIKES_S)
    (folder / "scenario.toml").write_text(
        f"duration_s = 60.0\nstrikes = [{strikes}]\ndamping = [{{on_s = 0.0, off_s = 60.0}}]\n"
    )
    config = ("--config", str(path))
    processes = {"rig": start("rig", folder, *config)}
    try:
        wait_until(block_path(configuration.camera.device).exists, 30.0)
        processes["supervisor"] = start(
            "supervisor", folder, *config, "--record-images", str(folder / "images.mcap")
        )
        words = ("--record", str(folder / "recording.mcap"), "--allow-non-realtime")
        processes["controller"] = start("controller", folder, *config, *words)
        wait_until(lambda: times_damping_began(folder) > 0, 30.0)
        time.sleep(5.0)
        processes["supervisor"].kill()
        killed = time.monotonic()
        time.sleep(1.5)
        began = times_damping_began(folder)
        processes["supervisor"] = start("supervisor", folder, *config)
        restarted = time.monotonic()
        # how long a supervisor takes to start is the computer's affair: a busy one was seen to take five seconds
        wait_until(lambda: times_damping_began(folder) > began, 30.0)
        time.sleep(4.0)
        processes["controller"].send_signal(signal.SIGKILL)
        controller_killed = time.monotonic()
        processes["controller"].wait()
        time.sleep(1.5)  # the recorder notices, drains, ends the file
        recording = open_recording(folder / "recording.mcap")
        origin = recording.header.origin_monotonic_s
        yield LiveRun(folder, recording, killed - origin, restarted - origin, controller_killed - origin)
    finally:
        for process in reversed(processes.values()):
            process.terminate()
        for process in processes.values():
            process.wait(20.0)


def test_a_killed_supervisor_brings_the_command_to_zero_within_a_fifth_of_a_second(live: LiveRun) -> None:
    """And the vibration goes on undamped meanwhile, so that the zero is not for want of something to damp."""
    fast = live.recording.columns("/fast")
    t, command = fast["time_s"], fast["joint_velocity_command_rad_s"]
    before = (t > live.killed_s - 1.5) & (t < live.killed_s)
    assert np.max(np.abs(command[before])) > 0.002
    silent = (t > live.killed_s + 0.2) & (t < live.restarted_s)
    assert np.sum(silent) > 500
    assert np.all(command[silent] == 0.0)


def test_a_restarted_supervisor_resumes_the_damping_by_itself(live: LiveRun) -> None:
    """Nothing else is started again. On a busy computer a prediction may be unsure for tenths of a second."""
    fast = live.recording.columns("/fast")
    t, command = fast["time_s"], fast["joint_velocity_command_rad_s"]
    after = (t > live.restarted_s) & (t < live.controller_killed_s)
    assert np.max(np.abs(command[after])) > 0.002
    estimates = live.recording.columns("/estimate")
    again = estimates["time_s"] > live.restarted_s
    assert np.sum(estimates["damping_status"][again] == "active") > 500


def test_the_recording_of_a_killed_controller_is_complete(live: LiveRun) -> None:
    """It is no cut file, holds the cycles to the last, and the public reader opens it."""
    assert not live.recording.cut
    fast = live.recording.columns("/fast")
    assert fast["time_s"][-1] > live.controller_killed_s - 0.1
    with (live.folder / "recording.mcap").open("rb") as file:
        reader = make_reader(file)
        topics = {channel.topic for channel in reader.get_summary().channels.values()}
        assert {"/fast", "/frames", "/estimate", "/link"} <= topics
        count = sum(1 for _ in reader.iter_messages(topics=["/fast"]))
        _, _, first = next(iter(reader.iter_messages(topics=["/frames"])))
    assert count == len(fast["time_s"])
    assert "displacement_px" in json.loads(first.data)


def test_replay_of_the_live_run_gives_the_same_numbers(live: LiveRun) -> None:
    """Delays, predictions and commands of every cycle, the skipped ones and the silence included."""
    comparison = compare_with_live(read_run(live.recording))
    assert comparison.cycles > 4000  # of ten thousand, on a machine that leaves every second one out
    assert comparison.identical, comparison.first_difference


def test_replay_of_the_recorded_images_gives_the_same_displacements(live: LiveRun) -> None:
    """The killed supervisor's images, tracked again: number for number."""
    images = open_recording(live.folder / "images.mcap")
    first = next(iter(images.messages("/images")))
    assert base64.b64decode(first.data).startswith(b"\x89PNG")
    comparison = compare_images(images)
    # a second of them at least, however busy the machine is
    assert comparison.frames > 60, f"{comparison.not_compared} images after the first that the recorder lost"
    assert comparison.different == 0, comparison.first_difference


def test_nothing_was_forged_or_malformed_and_the_sessions_are_counted(live: LiveRun) -> None:
    """Two supervisors, one after the other."""
    link = live.recording.columns("/link")
    assert link["sessions"][-1] == 2
    for reason in ("malformed", "forged", "foreign_version", "unexpected", "recorder_lost"):
        assert link[reason][-1] == 0


def test_no_shared_memory_is_left_by_the_controller(live: LiveRun) -> None:
    """The recorder of a killed controller removes its ring."""
    left = [p.name for p in block_path("x").parent.glob("stillarm-recorder-*")]
    mine = [name for name in left if not _alive(int(name.split("-")[2]))]
    assert mine == []


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True
