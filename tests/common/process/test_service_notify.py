"""What systemd sees of a daemon, its units, its lock and its log, without systemd."""

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from configparser import ConfigParser
from pathlib import Path

import pytest

from stillarm.common.files.configuration import Configuration
from stillarm.common.process.service_notify import Watchdog, notify
from stillarm.common.process.single_instance import hold_instance
from stillarm.common.recorder.recorder_client import RecorderClient
from stillarm.common.recorder.structured_log import log, log_line, log_start
from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.topics import TOPIC_INDEX, FastSample
from stillarm.common.user_error import UserError
from stillarm.controller.loop.realtime import CPU_LATENCY

ROOT = Path(__file__).parents[3]


@pytest.fixture
def listener(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as receiver:
        receiver.bind(str(tmp_path / "notify"))
        receiver.settimeout(30.0)
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
        yield receiver


def test_a_state_reaches_the_socket(listener: socket.socket) -> None:
    assert notify("READY=1")
    assert listener.recv(100) == b"READY=1"


def test_without_systemd_nothing_happens(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NOTIFY_SOCKET", raising=False)
    assert not notify("READY=1")
    monkeypatch.setenv("NOTIFY_SOCKET", "/nowhere/at/all")
    assert not notify("READY=1")


def test_the_watchdog_is_fed_only_while_the_counter_moves(
    listener: socket.socket, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WATCHDOG_USEC", "2000000")
    watchdog = Watchdog()
    fed = [
        watchdog.feed(counter, at)
        for counter, at in [(1, 0.0), (2, 0.5), (3, 1.1), (3, 2.2), (3, 9.0), (4, 9.1)]
    ]
    assert fed == [True, False, True, False, False, True]
    assert [listener.recv(100) for _ in range(3)] == [b"WATCHDOG=1"] * 3
    monkeypatch.delenv("WATCHDOG_USEC")
    assert not Watchdog().feed(5, 99.0)


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
    """Else two daemons would each hold the lock of a file of the same name."""
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


def test_a_line_is_one_json_object_whatever_is_in_it() -> None:
    line = log_line("controller", "warning", "two\nlines", 0.5, value=float("nan"), nested={"a": [1, "ü"]})
    assert "\n" not in line
    assert json.loads(line) == {
        "time": "1970-01-01T00:00:00.500+00:00",
        "level": "warning",
        "process": "controller",
        "event": "two\nlines",
        "value": None,
        "nested": {"a": [1, "ü"]},
    }


def test_the_configuration_is_in_the_first_line(capsys: pytest.CaptureFixture[str]) -> None:
    log_start("controller", Configuration(), "a.toml")
    log("controller", "error", "x")
    first, warning, second = capsys.readouterr().err.splitlines()
    assert "demo key" in json.loads(warning)["event"]
    assert json.loads(first)["configuration"]["link"]["controller_port"] == 47001
    assert json.loads(second)["level"] == "error"


@pytest.mark.parametrize("role", ["controller", "supervisor"])
def test_the_units_ask_for_what_the_daemons_need(role: str) -> None:
    unit = ConfigParser(strict=False, interpolation=None)
    unit.optionxform = str  # type: ignore[assignment,method-assign]
    unit.read(ROOT / "deploy" / "systemd" / f"stillarm-{role}.service")
    service = unit["Service"]
    assert service["Type"] == "notify" and service["NotifyAccess"] == "all"
    assert float(service["WatchdogSec"]) > 0.5 and service["Restart"] == "on-failure"
    assert f" {role} --config " in service["ExecStart"]
    assert service["KillMode"] == "mixed"  # SIGTERM to the main process: it fades, then its recorder finishes
    if role == "controller":
        assert service["LimitRTPRIO"] == "99" and service["LimitMEMLOCK"] == "infinity"


def test_the_units_user_is_made_and_may_hold_the_processors_latency() -> None:
    """Without, the controller would refuse to start as a service."""
    users = (ROOT / "deploy" / "sysusers" / "stillarm.conf").read_text().splitlines()
    rule = (ROOT / "deploy" / "udev" / "80-stillarm.rules").read_text()
    unit = (ROOT / "deploy" / "systemd" / "stillarm-controller.service").read_text()
    assert "User=stillarm" in unit and "m stillarm realtime" in users
    assert CPU_LATENCY.grant.removeprefix("a udev rule ").split(", and ")[0] in rule
    assert "DeviceAllow" not in unit  # it would close all other devices, and opens none


@pytest.mark.slow
def test_the_recorders_process_feeds_the_watchdog_while_the_loop_puts_messages(
    listener: socket.socket, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And no longer than that, though both processes live."""
    monkeypatch.setenv("WATCHDOG_USEC", "100000")
    header = RecordingHeader(
        program_version="0", configuration="", configuration_name="", model="", method="m", kind="live"
    )
    client = RecorderClient.start(None, header)
    try:
        assert listener.recv(100) == b"WATCHDOG=1"  # it has begun to watch
        for cycle in range(3):
            client.put(TOPIC_INDEX["/fast"], FastSample(cycle * 0.001, cycle))
            assert listener.recv(100) == b"WATCHDOG=1"
        listener.settimeout(0.7)
        with pytest.raises(TimeoutError):
            listener.recv(100)
    finally:
        client.close()
