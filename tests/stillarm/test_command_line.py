"""The command line: help for every command, one line for what a user can mend."""

import subprocess
import sys
from pathlib import Path

import pytest

from stillarm.main import COMMANDS, main


@pytest.mark.parametrize("command", sorted(COMMANDS))
def test_every_command_has_help(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Exit status 0, and the arguments named."""
    with pytest.raises(SystemExit) as stop:
        main([command, "--help"])
    assert stop.value.code == 0
    assert "usage: stillarm" in capsys.readouterr().out


def one_line(capsys: pytest.CaptureFixture[str]) -> str:
    error = capsys.readouterr().err
    assert error.count("\n") == 1, error
    return error


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
        (["recover", "absent.mcap"], "absent.mcap"),
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
    model = Path(__file__).parent.parent.parent / "configs" / "model.toml"
    monkeypatch.chdir(tmp_path)
    assert main([str(model) if word == "MODEL" else word for word in words]) == 1
    assert says in one_line(capsys)


def test_an_unknown_command_or_argument_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    """With the command that explains."""
    for words in (["dmeo"], ["replay", "--methd", "x"], []):
        with pytest.raises(SystemExit) as stop:
            main(words)
        assert stop.value.code == 2
        assert "--help" in one_line(capsys)


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


def test_the_daemons_load_no_heavy_package() -> None:
    """Starting the controller or the supervisor must not import matplotlib, scipy or numba."""
    code = (
        "import sys, controller.daemon, supervisor.daemon;"
        "print([name for name in ('matplotlib', 'scipy', 'numba') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
