"""The command line: help for every command, one line for what a user can mend."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from stillarm.common.link.free_ports import free_ports
from stillarm.main import COMMANDS, main
from tests.fixtures.commands import one_line

RIG = """
model = "model.toml"
[accelerometer]
bus = "memory:test-command-i2c"
[camera]
driver = "shared_memory"
device = "test-command-camera"
"""


@pytest.mark.parametrize("command", sorted(COMMANDS))
def test_every_command_has_help(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Exit status 0, and the arguments named."""
    with pytest.raises(SystemExit) as stop:
        main([command, "--help"])
    assert stop.value.code == 0
    assert "usage: stillarm" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["replay", "absent.mcap"], "absent.mcap"),
        (["simulate", "--model", "absent.toml", "-o", "rec.mcap"], "absent.toml"),
        (["simulate", "--model", "MODEL", "--scenario", "dmeo", "-o", "rec.mcap"], "demo"),
        (["simulate", "--model", "MODEL", "--method", "corelation", "-o", "rec.mcap"], "correlation"),
        (["controller", "--config", "absent.toml"], "absent.toml"),
        (["import", "absent", "-o", "rec.mcap"], "absent"),
        (["import", "absent.csv", "--map", "in=2", "--rate-hz", "1", "-o", "rec.mcap"], "input=COLUMN"),
        (["demo", "--duration-s", "3"], "12"),
        (["demo", "--duration-s", "nan"], "600"),
        (["demo", "--duration-s", "1e9"], "600"),
        (["demo", "--out", "MODEL"], "folder"),
        (["simulate", "--model", "MODEL", "-o", "MODEL/x.mcap"], "folder"),
        (["simulate", "--model", "COPY", "-o", "COPY"], "is no recording"),
        (["recover", "absent.mcap"], "absent.mcap"),
        (["benchmark", "vision", "--duration-s", "3"], "loop, flood, soak"),
    ],
)
def test_a_mistake_is_one_line(
    words: list[str],
    says: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Names what is wrong and what is allowed; exit status 1; no traceback."""
    model = Path(__file__).parents[2] / "configs" / "model.toml"
    monkeypatch.chdir(tmp_path)
    copy = tmp_path / "copy.toml"
    copy.write_text(model.read_text())
    assert main([word.replace("MODEL", str(model)).replace("COPY", str(copy)) for word in words]) == 1
    assert copy.read_text() == model.read_text()
    assert says in one_line(capsys)


def test_an_unknown_command_or_argument_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    """The line names the command that explains."""
    for words in (["dmeo"], ["replay", "--methd", "x"], []):
        with pytest.raises(SystemExit) as stop:
            main(words)
        assert stop.value.code == 2
        assert "--help" in one_line(capsys)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "content", "says"),
    [
        ("supervisor", '[camera]\ndevice = "7654"\n', "camera.device = '7654'"),
        ("supervisor", '[camera]\ndriver = "file"\ndevice = "noise.avi"\n', "noise.avi"),
        ("rig", RIG, "model.toml: arm.length_m"),
        ("rig", RIG.replace("model.toml", "quick.toml"), "timing.capture_delay_s = 0.0"),
        (
            "rig",
            'model = "slow.toml"\n[accelerometer]\nbus = "memory:test-command-i2c"\n',
            "camera.driver = 'opencv'",
        ),
    ],
)
def test_a_daemon_that_cannot_start_says_why_in_one_line(
    command: str, content: str, says: str, tmp_path: Path
) -> None:
    """Nothing of what libraries warn of beside it, and no second line of a second process."""
    (tmp_path / "noise.avi").write_bytes(bytes(range(256)) * 40)
    (tmp_path / "model.toml").touch()
    (tmp_path / "quick.toml").write_text("[arm]\nlength_m = 2.0\n[timing]\ncapture_delay_s = 0.0\n")
    (tmp_path / "slow.toml").write_text("[arm]\nlength_m = 2.0\n")
    path = tmp_path / "rig.toml"
    path.write_text(
        content + f"[link]\nsupervisor_port = {free_ports(1)[0]}\n"
    )  # the usual one may be in use
    words = [sys.executable, "-m", "stillarm", command, "--config", str(path)]
    done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1 and says in done.stderr, done.stderr


def test_what_the_operating_system_refuses_is_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also for an unforeseen error: a full disk while a table is written."""

    def full(arguments: object) -> int:
        raise OSError(28, "No space left on device", "replay/frames.csv")

    monkeypatch.setattr("stillarm.commands.recordings.replay_command.run", full)
    assert main(["replay", "rec.mcap"]) == 1
    assert "replay/frames.csv: no space left on device" in one_line(capsys)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_sigterm_unwinds_as_ctrl_c_does_even_where_a_shell_has_that_ignored(
    number: signal.Signals, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A terminated demo therefore ends its processes, and a moving joint always stops."""
    unwound = []

    def told_to_end(arguments: object) -> int:
        try:
            os.kill(os.getpid(), number)
            time.sleep(5.0)
        finally:
            unwound.append(True)
        return 0

    before = signal.signal(number, signal.SIG_IGN)
    monkeypatch.setattr("stillarm.commands.recordings.replay_command.run", told_to_end)
    try:
        assert main(["replay", "rec.mcap"]) == 130
    finally:
        signal.signal(number, before)
    assert unwound == [True]
    assert "interrupted" in one_line(capsys)


def test_a_wrong_key_in_the_configuration_is_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """File, key, value, and the nearest valid key."""
    path = tmp_path / "rig.toml"
    path.write_text("[controller.damping]\nadded_dampin_ratio = 0.1\n")
    assert main(["controller", "--config", str(path)]) == 1
    said = one_line(capsys)
    for part in (
        str(path),
        "controller.damping.added_dampin_ratio",
        "0.1",
        "controller.damping.added_damping_ratio",
    ):
        assert part in said


@pytest.mark.slow
def test_the_daemons_load_no_heavy_package() -> None:
    """Starting the controller or the supervisor must not import matplotlib, scipy or numba."""
    code = (
        "import sys, stillarm.controller.loop.daemon, stillarm.supervisor.daemon;"
        "print([name for name in ('matplotlib', 'scipy', 'numba') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
