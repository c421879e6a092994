"""Real-time privileges: named with their remedy where they are missing, held where they are there."""

import ctypes
import gc
import os
import subprocess
import sys
from pathlib import Path

import pytest

from stillarm.common.user_error import UserError
from stillarm.controller.loop import realtime
from stillarm.controller.loop.daemon import run
from stillarm.controller.loop.realtime import CPU_LATENCY, FIFO, MEMORY, RealTime, missing_privileges

ROOT = Path(__file__).parents[3]


def refuse(*arguments: object) -> None:
    raise PermissionError(1, "Operation not permitted")


@pytest.fixture
def unprivileged(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A process that may nothing of it."""
    latency = tmp_path / "cpu_dma_latency"
    latency.touch()
    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    monkeypatch.setattr(realtime, "_may_lock_memory", lambda: False)
    monkeypatch.setattr(realtime, "_CPU_LATENCY", latency)
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != latency)


@pytest.mark.usefixtures("unprivileged")
def test_each_missing_privilege_is_named_with_how_to_grant_it() -> None:
    """All three, for a unit and for a login."""
    missing = missing_privileges()
    assert missing == [FIFO, MEMORY, CPU_LATENCY]
    told = "; ".join(map(str, missing))
    for words in (
        "LimitRTPRIO=99",
        "rtprio 99",
        "setcap",
        "LimitMEMLOCK=infinity",
        "memlock unlimited",
        "udev",
    ):
        assert words in told


@pytest.mark.usefixtures("unprivileged")
def test_without_them_the_controller_refuses_before_it_opens_anything(tmp_path: Path) -> None:
    """In one line that says what would let it run; no recording is begun, no signal taken over."""
    (tmp_path / "model.toml").write_text((ROOT / "configs" / "model.toml").read_text())
    configuration = tmp_path / "config.toml"
    configuration.write_text('model = "model.toml"\n')
    with pytest.raises(
        UserError, match=r"LimitRTPRIO=99.*LimitMEMLOCK=infinity.*--allow-non-realtime"
    ) as refused:
        run(configuration, tmp_path / "rec.mcap", 1.0, allow_non_realtime=False)
    assert "\n" not in str(refused.value)
    assert not (tmp_path / "rec.mcap").exists()


def test_asking_changes_nothing() -> None:
    """Scheduler, collector and place are as before."""
    before = os.sched_getscheduler(0), os.sched_getaffinity(0), gc.isenabled(), gc.get_freeze_count()
    missing_privileges()
    assert (
        os.sched_getscheduler(0),
        os.sched_getaffinity(0),
        gc.isenabled(),
        gc.get_freeze_count(),
    ) == before


INSIDE = """
import gc, os, subprocess, sys
from pathlib import Path
from stillarm.controller.loop.realtime import RealTime
realtime = RealTime()
missing = [each.what for each in realtime.enter()]
links = [f"/proc/self/fd/{number}" for number in os.listdir("/proc/self/fd")]
held = [os.readlink(link) for link in links if os.path.exists(link)]
print(os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK == os.SCHED_FIFO)
print(len(os.sched_getaffinity(0)), gc.isenabled(), gc.get_freeze_count() > 0)
print(int(next(l for l in Path("/proc/self/status").read_text().splitlines() if l.startswith("VmLck")).split()[1]) > 0)
print("/dev/cpu_dma_latency" in held)
child = "import os; print(os.sched_getscheduler(0) == os.SCHED_OTHER)"
print(subprocess.run([sys.executable, "-c", child], capture_output=True, text=True).stdout.strip())
realtime.leave(); realtime.leave()
print(gc.isenabled(), missing)
"""


@pytest.mark.slow
@pytest.mark.skipif(bool(missing_privileges()), reason="needs the real-time privileges")
def test_with_them_all_of_it_holds_and_children_are_ordinary() -> None:
    """In a process of its own: FIFO, one processor, frozen collector, locked memory, latency held."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-c", INSIDE], capture_output=True, text=True, check=True, env=environment
    )
    fifo, place, locked, latency, child, after = done.stdout.splitlines()
    assert (fifo, place, locked, child) == ("True", "1 False True", "True", "True")
    assert latency == str(Path("/dev/cpu_dma_latency").exists())
    assert after == "True []"


@pytest.mark.slow
def test_what_cannot_be_done_is_returned_and_the_rest_is_done(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Nothing raises."""
    monkeypatch.setattr(realtime, "run_fifo", lambda priority: False)
    monkeypatch.setattr(realtime, "_CPU_LATENCY", tmp_path)  # a folder cannot be opened for writing
    before = os.sched_getaffinity(0)
    entered = RealTime()
    try:
        missing = entered.enter()
        assert FIFO in missing and CPU_LATENCY in missing
        assert len(os.sched_getaffinity(0)) == 1
    finally:
        entered.leave()
        os.sched_setaffinity(0, before)
        ctypes.CDLL(None).munlockall()
