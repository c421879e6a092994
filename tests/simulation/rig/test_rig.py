"""The rig's process where it cannot start: nothing of another rig's is touched, nothing is left behind."""

import socket
import time
from pathlib import Path

import pytest

from stillarm.common.memory.shared_memory import SharedBlock, block_path
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
