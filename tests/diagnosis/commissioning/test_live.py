"""What runs the moves on a rig: the configuration that it makes, what it takes from telemetry, how it ends."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from math import nan
from pathlib import Path

import msgspec
import pytest
import tomli_w

from stillarm.commands.rig.operate_command import operate
from stillarm.common.files.configuration import Configuration, Controller, Damping, Dither, Link, Safety
from stillarm.common.files.model import load_model
from stillarm.common.files.scenario import Scenario
from stillarm.common.link.free_ports import free_ports
from stillarm.common.recorder.telemetry import telemetry_map
from stillarm.common.recording.topics import FastSample, FrameSample
from stillarm.common.user_error import UserError
from stillarm.diagnosis.commissioning import live
from stillarm.diagnosis.commissioning.live import LiveRig, commissioning_configuration, feed
from stillarm.diagnosis.commissioning.stop_listener import StopListener
from stillarm.diagnosis.commissioning.watch import Bounds, Watch
from tests.fixtures.probed import measured

CONFIGS = Path(__file__).parents[3] / "configs"
USERS = Configuration(
    model="arm.toml",
    link=Link(controller_port=50001),
    controller=Controller(
        method="fused",
        arm_at_start=False,
        schedule="/own/schedule.toml",
        reference_shaping="zv",
        damping=Damping(without_schedule=True),
        dither=Dither(enabled=True),
        safety=Safety(emergency_stop_input="/sys/class/gpio/gpio17/value", checks_before_arming=("vision",)),
    ),
)


@contextmanager
def simulated_rig(folder: Path) -> Iterator[LiveRig]:
    """Nothing of it runs."""
    (folder / "arm.toml").write_text((CONFIGS / "model.toml").read_text())
    path = folder / "rig.toml"
    here = Configuration(model="arm.toml", link=Link(reference_port=free_ports(1)[0]))
    path.write_text(tomli_w.dumps(msgspec.to_builtins(here)))
    with closing(LiveRig(path, load_model(folder / "arm.toml"), folder, allow_non_realtime=True)) as rig:
        yield rig


def test_nothing_adds_to_the_moves_and_the_stops_stay(tmp_path: Path) -> None:
    """No damping, dither or shaping; the emergency stop, the ports and the devices are the user's own."""
    made = commissioning_configuration(USERS, tmp_path / "own.toml", tmp_path / "moves.toml", 4242)
    controller = made.controller
    assert controller.schedule == str(tmp_path / "moves.toml")
    assert not controller.damping.without_schedule and not controller.dither.enabled
    assert controller.reference_shaping == "none" and controller.arm_at_start
    assert controller.safety.emergency_stop_input == USERS.controller.safety.emergency_stop_input
    assert made.link == USERS.link and made.drive == USERS.drive and made.camera == USERS.camera
    assert made.model == str(tmp_path / "arm.toml")
    assert (made.telemetry.host, made.telemetry.port, made.telemetry.every_cycles) == ("127.0.0.1", 4242, 1)


def test_telemetry_feeds_the_watch() -> None:
    """As the controller's recorder words it, through msgpack."""
    watch = Watch(Bounds(0.05, 10.0, 5.0))
    frames = [
        FrameSample(0.5, 500, k, 0.5, 0.4, 400, 0, displacement_px=px) for k, px in enumerate((1.0, nan, 9.0))
    ]
    for topic, message in [
        ("/fast", FastSample(0.499, 499, acceleration_m_s2=0.1, joint_position_rad=0.2)),
        *(("/frames", frame) for frame in frames),
        ("/fast", FastSample(0.501, 501, acceleration_m_s2=nan, joint_position_rad=0.24)),
    ]:
        feed(watch, msgspec.msgpack.decode(msgspec.msgpack.encode(telemetry_map(topic, message))))
    assert watch.exceeded is None and watch.swing_px == 8.0
    feed(watch, telemetry_map("/fast", FastSample(0.502, 502, joint_position_rad=0.26)))
    assert "the joint is 0.060 rad" in str(watch.exceeded)


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        ("", "it said nothing"),
        ('{"level":"error","event":"fault: emergency stop; release"}\n', "fault: emergency stop; release"),
        (
            "stillarm: link.controller_port = 47001: taken; stop it\n",
            "link.controller_port = 47001: taken; stop it",
        ),
    ],
)
def test_the_controller_s_last_words(tmp_path: Path, said: str, expected: str) -> None:
    log = tmp_path / "c.log"
    log.write_text(said)
    assert live._last_words(log) == expected
    assert live._said_error(log) == ("error" in said)


def test_a_fault_in_the_recording_is_told() -> None:
    live._refuse_fault({"state": ["armed", "degraded"], "reason": ["", "uncommissioned"]})
    with pytest.raises(UserError, match="stopped by the controller: emergency stop; the joint stands"):
        live._refuse_fault({"state": ["armed", "fault"], "reason": ["", "emergency stop"]})


def test_moves_ended_by_lost_telemetry_are_no_measurement() -> None:
    """Where the recording shows a bound exceeded, too, it is what it says."""
    bounds, recorded = Bounds(0.05, 100.0, 10.0), measured(100.0, 0.1)
    watch = Watch(bounds)
    live._refuse_blind_watch(watch, recorded, bounds)
    watch.image(0.1, 0.0)
    watch.cycle(0.9, 0.0, 0.0)
    with pytest.raises(UserError, match=r"no image was measured for 0\.5 s in the telemetry .* too busy"):
        live._refuse_blind_watch(watch, recorded, bounds)
    live._refuse_blind_watch(watch, recorded, Bounds(0.05, 1e-9, 10.0))


def test_a_stop_between_two_parts_lets_no_other_begin(tmp_path: Path) -> None:
    """And it ends the rest. Closed, the rig listens no more."""
    with simulated_rig(tmp_path) as rig:
        rig.rest(0.0)
        rig._between = StopListener(rig._configuration.link)
        operate(rig._configuration, "stop")
        rig.rest(30.0)
        with pytest.raises(
            UserError, match="commission: emergency stop, between two parts; the joint stands"
        ):
            rig.record("moves", Scenario(duration_s=1.0), Bounds(0.05, 100.0, 10.0))
    assert not list(tmp_path.glob("*.log")) and rig._between is None


@pytest.mark.slow
def test_the_controller_is_told_to_stop_on_every_way_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By SIGTERM, which its loop answers by coming to rest; here by a process that notes it."""
    note = tmp_path / "note"
    script = (
        "import signal, sys, time\n"
        f"signal.signal(signal.SIGTERM, lambda *a: (open({str(note)!r}, 'w').write('asked'), sys.exit(0)))\n"
        "print('ready', flush=True)\ntime.sleep(60)\n"
    )
    started = subprocess.Popen

    def stand_in(words: list[str], **rest: object) -> subprocess.Popen[bytes]:
        process: subprocess.Popen[bytes] = started([sys.executable, "-c", script], **rest)  # type: ignore[call-overload]
        return process

    monkeypatch.setattr(subprocess, "Popen", stand_in)
    log = tmp_path / "c.log"
    with pytest.raises(KeyboardInterrupt), live._controller(["--x"], log) as process:
        while b"ready" not in log.read_bytes():
            assert process.poll() is None
        raise KeyboardInterrupt
    assert process.returncode == 0 and note.read_text() == "asked"
    with pytest.raises(ProcessLookupError):
        os.kill(process.pid, signal.SIGTERM)
