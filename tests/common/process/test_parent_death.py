"""A demo that is killed takes its processes with it."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from stillarm.common.process.parent_death import beginning, ended_with_parent

pytestmark = pytest.mark.slow

_ROOT = Path(__file__).parents[3]
_PARENT = """
import subprocess, sys, time
from stillarm.common.process.parent_death import ended_with_parent
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"], preexec_fn=ended_with_parent())
print(child.pid, flush=True)
time.sleep(60)
"""


def test_a_killed_parent_s_child_ends() -> None:
    """SIGKILL leaves the parent no time to say so; the kernel does."""
    parent = subprocess.Popen([sys.executable, "-c", _PARENT], stdout=subprocess.PIPE, cwd=_ROOT)
    assert parent.stdout is not None
    with parent.stdout as said:
        child = int(said.readline())
    parent.kill()
    parent.wait()
    deadline = time.monotonic() + 120.0
    while _runs(child):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_a_child_whose_parent_lives_runs_on() -> None:
    child = subprocess.Popen(
        [sys.executable, "-c", "input()"],
        stdin=subprocess.PIPE,
        preexec_fn=ended_with_parent(),  # noqa: PLW1509 - it calls the kernel only
    )
    assert child.poll() is None
    child.communicate(b"\n")
    assert child.returncode == 0


def test_a_child_of_lower_priority_says_so() -> None:
    words = [sys.executable, "-c", "import os; print(os.nice(0))"]
    nice = beginning(7)
    said = subprocess.run(words, stdout=subprocess.PIPE, check=True, preexec_fn=nice).stdout
    assert int(said) == os.nice(0) + 7


def _runs(process: int) -> bool:
    """Whether a process is there and has not ended (an ended one may wait for whoever adopted it)."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except (FileNotFoundError, ProcessLookupError):
        return False
