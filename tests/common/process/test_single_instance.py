"""One daemon of a kind at a time: its lock, also of one that was killed."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from stillarm.common.process.single_instance import hold_instance
from stillarm.common.user_error import UserError
from tests.fixtures.imports import ROOT


def test_a_second_daemon_is_refused_and_names_the_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RUNTIME_DIRECTORY", str(tmp_path))
    held = hold_instance("controller", 47001)
    with pytest.raises(UserError, match=rf"process {os.getpid()}\)"):
        hold_instance("controller", 47001)
    hold_other = hold_instance("controller", 47002)
    os.close(held)
    os.close(hold_other)
    os.close(hold_instance("controller", 47001))


@pytest.mark.slow
def test_the_lock_of_a_killed_daemon_is_no_obstacle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its file stays, with a number that may be anybody's by now."""
    monkeypatch.setenv("RUNTIME_DIRECTORY", str(tmp_path))
    code = (
        "import time; from stillarm.common.process.single_instance import hold_instance\n"
        "hold_instance('supervisor', 5); print('held', flush=True); time.sleep(600)"
    )
    process = subprocess.Popen([sys.executable, "-c", code], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "held\n"
    with pytest.raises(UserError, match=f"process {process.pid}"):
        hold_instance("supervisor", 5)
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdout.close()
    assert (tmp_path / "stillarm-supervisor-5.lock").read_text() == f"{process.pid}\n"
    os.close(hold_instance("supervisor", 5))
    assert (tmp_path / "stillarm-supervisor-5.lock").read_text() == f"{os.getpid()}\n"


@pytest.mark.slow
def test_a_daemon_that_ends_removes_its_lock_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """But never one that is another's by now."""
    monkeypatch.setenv("RUNTIME_DIRECTORY", str(tmp_path))
    path = tmp_path / "stillarm-controller-5.lock"
    code = (
        "from stillarm.common.process.single_instance import hold_instance\nhold_instance('controller', 5)\n"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)
    assert not path.exists()
    replaced = code + f"import os; os.unlink({str(path)!r}); open({str(path)!r}, 'w').write('another')"
    subprocess.run([sys.executable, "-c", replaced], cwd=ROOT, check=True)
    assert path.read_text() == "another"


def test_a_lock_file_removed_while_it_was_being_locked_is_made_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Otherwise two daemons could each hold a lock on a file of the same name."""
    monkeypatch.setenv("RUNTIME_DIRECTORY", str(tmp_path))
    path = tmp_path / "stillarm-controller-5.lock"
    locks: list[int] = []

    def remove_then_lock(descriptor: int, how: int) -> None:
        if not locks:
            path.unlink()
        locks.append(how)

    monkeypatch.setattr("stillarm.common.process.single_instance.fcntl.flock", remove_then_lock)
    held = hold_instance("controller", 5)
    assert len(locks) == 2
    assert os.fstat(held).st_ino == path.stat().st_ino
    os.close(held)
