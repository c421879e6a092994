"""What systemd sees of a daemon, its units, its lock and its log, without systemd."""

import socket
from collections.abc import Iterator
from configparser import ConfigParser
from pathlib import Path

import pytest

from stillarm.common.process.service_notify import Watchdog, notify
from stillarm.common.recorder.recorder_client import RecorderClient
from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.topics import TOPIC_INDEX, FastSample
from stillarm.controller.loop.realtime import CPU_LATENCY
from tests.fixtures.imports import ROOT


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
    """Otherwise the controller would refuse to start as a service."""
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
