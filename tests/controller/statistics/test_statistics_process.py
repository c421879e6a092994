"""The process that tells of the loop: the lines it writes, the watchdog it feeds, and its end with the loop's."""

import json
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from stillarm.controller.safety.table import State
from stillarm.controller.statistics.loop_block import LoopBlock
from stillarm.controller.statistics.statistics_process import start_statistics, stop_statistics

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]
LOOP = """
import os, time
from stillarm.controller.statistics.loop_block import LoopBlock
from stillarm.controller.safety.table import State
from stillarm.controller.statistics.statistics_process import start_statistics
block = LoopBlock(f"loop-test-{os.getpid()}", create=True)
statistics = start_statistics(block.name, os.getpid())
print(statistics.pid, flush=True)
for cycle in range(100000):
    block.end_cycle(cycle, 1e-5, 1e-4, 0, State.ARMED, None)
    time.sleep(0.01)
"""


def test_the_watchdog_is_fed_while_the_loops_counter_moves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And no longer than that, though the loop's process lives, and though there is no recorder."""
    monkeypatch.setenv("WATCHDOG_USEC", "20000")
    monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
    block = LoopBlock(f"loop-test-{os.getpid()}", create=True)
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind(str(tmp_path / "notify"))
        listener.settimeout(30.0)
        process = start_statistics(block.name, os.getpid())
        try:
            for cycle in range(3):
                block.end_cycle(cycle, 1e-5, 1e-4, 0, State.ARMED, None)
                assert listener.recv(100) == b"WATCHDOG=1"
            listener.settimeout(0.5)
            with pytest.raises(TimeoutError):
                while True:  # the feed before the first cycle may have come first
                    listener.recv(100)
        finally:
            stop_statistics(process)
            block.close()


def test_a_killed_loop_is_told_and_nothing_is_said_of_its_recorder() -> None:
    """Which ends with the loop; the block is removed, and the process is gone."""
    loop = subprocess.Popen(
        [sys.executable, "-c", LOOP], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert loop.stdout is not None and loop.stderr is not None
    with loop.stdout, loop.stderr:
        loop.stdout.readline()
        line = json.loads(loop.stderr.readline())
        assert line["event"] == "loop" and line["cycles"] > 0 and line["state"] == "armed"
        loop.send_signal(signal.SIGKILL)
        said = [
            json.loads(text)["event"] for text in loop.stderr.read().splitlines()
        ]  # until both have ended
    loop.wait()
    assert said[-1] == "the loop is gone"
    assert set(said[:-1]) <= {"loop", "cycles missed"}
    assert not (Path("/dev/shm") / f"stillarm-loop-test-{loop.pid}").exists()
