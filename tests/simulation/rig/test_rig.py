"""The rig's process where it cannot start: nothing of another rig's is touched, nothing is left behind."""

import multiprocessing
import socket
import time
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from stillarm.common.files.configuration import load_configuration
from stillarm.common.files.model import Timing, load_model
from stillarm.common.files.scenario import Scenario
from stillarm.common.memory.shared_memory import SharedBlock, block_path
from stillarm.common.recording.topics import TrueState
from stillarm.common.user_error import UserError
from stillarm.controller.loop.schedule import CycleClock
from stillarm.simulation.rig import rig

_NAMES = ("test-rig-i2c", "test-rig-camera-pose")


@pytest.fixture
def configuration(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A rig of its own; the test's process keeps its place in the scheduler's queue and its signals."""
    monkeypatch.setattr(rig, "raise_priority", lambda niceness: None)
    monkeypatch.setattr(rig, "StopSignal", lambda: None)
    (tmp_path / "model.toml").write_text("[arm]\nlength_m = 2.0\n")
    path = tmp_path / "rig.toml"
    path.write_text(
        '[accelerometer]\nbus = "memory:test-rig-i2c"\n'
        '[camera]\ndriver = "shared_memory"\ndevice = "test-rig-camera"\n[drive]\ngateway_port = PORT\n'
    )
    return path


def test_a_second_rig_leaves_the_first_one_s_memory_alone(configuration: Path) -> None:
    """The port tells that another rig runs; the arm that the controller feels must not vanish."""
    first = [SharedBlock(name, 64, create=True) for name in _NAMES]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as held:
        held.bind(("127.0.0.1", 0))
        port = held.getsockname()[1]
        configuration.write_text(configuration.read_text().replace("PORT", str(port)))
        try:
            with pytest.raises(UserError, match=f"drive.gateway_port: cannot listen on 127.0.0.1:{port}"):
                rig.run(configuration, None, seed=None, scenario=None)
            assert [block.replaced() for block in first] == [False, False]
        finally:
            for block in first:
                block.close()


def test_what_a_rig_made_before_it_failed_is_removed(
    configuration: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No memory for the second block: the first is given back, and the port."""

    def none_left(name: str, *, create: bool) -> None:
        raise UserError("no memory")

    monkeypatch.setattr(rig, "PoseHistory", none_left)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    configuration.write_text(configuration.read_text().replace("PORT", str(port)))
    with pytest.raises(UserError, match="no memory"):
        rig.run(configuration, None, seed=None, scenario=None)
    assert not any(block_path(name).exists() for name in _NAMES)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", port))


@pytest.mark.parametrize(
    ("effect", "told"),
    [
        (
            'cause = "clock_step"\nonset_s = 1.0\nstep_s = 0.1\nclock = "all"',
            "a live rig cannot step the controller's",
        ),
        ('cause = "clock_step"\nonset_s = 1.0\nstep_s = 0.1\nclock = "camera"', "stamped = true"),
        ('cause = "gear_backlash"\ngap_mm = 1.0', "gear_backlash has no such parameter"),
    ],
)
def test_an_effect_that_the_rig_cannot_obey_is_refused_in_one_line(
    configuration: Path, effect: str, told: str
) -> None:
    model = configuration.with_name("model.toml")
    model.write_text(f"{model.read_text()}[[effects]]\n{effect}\n")
    configuration.write_text(configuration.read_text().replace("PORT", "47999"))
    with pytest.raises(UserError, match=told) as refused:
        rig.run(configuration, None, seed=None, scenario=None)
    assert str(refused.value).startswith(f"{model}: effects") and "\n" not in str(refused.value)
    assert not any(block_path(name).exists() for name in _NAMES)


class _CommandedAt:
    """A drive that has been commanded once it is looked at for the nth time."""

    def __init__(self, look: int) -> None:
        self._look, self.looks, self.seen_s = look, 0, 0.0

    @property
    def commanded(self) -> bool:
        return self.looks >= self._look

    def poll(self, now_s: float) -> float:
        self.looks, self.seen_s = self.looks + 1, now_s
        return 0.0


def test_the_plant_steps_a_third_of_a_cycle_after_the_first_command() -> None:
    clock, drive = CycleClock(0.01, time.monotonic() - 1.0), _CommandedAt(2)
    rig.fall_into_step(clock, 7, 0.01, drive)  # that cycle is long due
    assert drive.looks == 0
    clock = CycleClock(0.01, time.monotonic() + 10.0)
    rig.fall_into_step(clock, 3, 0.01, drive)
    assert drive.looks == 2
    assert clock.origin_s + 3 * 0.01 == pytest.approx(drive.seen_s + 0.003, abs=1e-6)


def test_without_a_command_the_plant_keeps_its_own_time() -> None:
    now = time.monotonic()
    clock = CycleClock(0.01, now)
    rig.fall_into_step(clock, 3, 0.01, _CommandedAt(10**9))
    assert clock.origin_s == now
    assert time.monotonic() >= now + 0.03


def test_a_step_is_made_for_the_controller_s_next_reading() -> None:
    """A command is seen some 0.3 of a cycle after its cycle began; the step that follows shows the next one's start."""
    clock, drive = CycleClock(0.01, time.monotonic() + 10.0), _CommandedAt(2)
    rig.fall_into_step(clock, 3, 0.01, drive)
    next_reading_s = drive.seen_s - 0.003 + 0.01
    assert clock.origin_s + (3 + rig.AHEAD) * 0.01 == pytest.approx(next_reading_s, abs=1e-6)


class _Heard:
    """A recorder that notes what it was given, and when."""

    def __init__(self) -> None:
        self.truth: list[tuple[float, float]] = []

    def put(self, topic: int, message: object) -> None:
        if isinstance(message, TrueState):
            self.truth.append((time.monotonic(), message.time_s))


def test_sensor_and_truth_and_pose_hold_for_the_instant_of_the_next_reading(
    configuration: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        configuration.write_text(configuration.read_text().replace("PORT", str(probe.getsockname()[1])))
    model = msgspec.structs.replace(
        load_model(configuration.with_name("model.toml")), timing=Timing(cycle_s=0.02)
    )
    loaded = load_configuration(configuration)
    plant = rig._PlantProcess(loaded, model, Scenario(duration_s=10.0), loaded.rig)
    heard, steps = _Heard(), iter([False] * 12)
    receiver, sender = multiprocessing.Pipe(duplex=False)
    try:
        plant.run(_Until(steps), heard, receiver, lambda: True)  # type: ignore[arg-type]
        assert plant._poses.newest_time_s() == heard.truth[-1][1]
    finally:
        plant.close()
        receiver.close()
        sender.close()
    ahead_s = max(holds_for_s - made_s for made_s, holds_for_s in heard.truth)  # less what a step came late
    assert 0.5 * rig.AHEAD * 0.02 < ahead_s <= rig.AHEAD * 0.02


class _Until:
    """A stop signal that comes when the values have run out."""

    def __init__(self, values: Iterator[bool]) -> None:
        self._values = values

    def __bool__(self) -> bool:
        return next(self._values, True)
