"""`stillarm panel` tells a user's mistake in one line, and starts where there is none."""

import socket
from pathlib import Path

import pytest

from stillarm.main import main

ROOT = Path(__file__).parents[4]
CONFIG = ["--config", str(ROOT / "configs" / "simulated_rig.toml")]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--recordings", "/nowhere"], "--recordings /nowhere: no such folder"),
        (["--config", "/nowhere.toml"], "/nowhere.toml"),
        (["--certificate", "/nowhere.pem"], "--certificate /nowhere.pem: cannot be used"),
        (["--host", "nowhere.invalid", "--port", "0"], "panel: cannot serve on nowhere.invalid:0"),
    ],
)
def test_a_mistake_is_one_line(
    words: list[str],
    said: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    config = tmp_path / "c.toml"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    config.write_text(f"[telemetry]\npanel_port = {port}\n")
    given = ["panel", "--config", str(config), "--recordings", str(tmp_path), *words]
    assert main(given) == 1
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1


def test_a_taken_telemetry_port_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        config = tmp_path / "c.toml"
        config.write_text(f"[telemetry]\npanel_port = {taken.getsockname()[1]}\n")
        assert main(["panel", "--config", str(config), "--recordings", str(tmp_path), "--port", "0"]) == 1
    assert "telemetry.panel_port: cannot listen" in capsys.readouterr().err


@pytest.mark.parametrize("port", ["-1", "65536", "x", "1.5", ""])
def test_a_port_that_is_none_is_refused(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["panel", *CONFIG, "--port", port])
    assert "a port from 0" in capsys.readouterr().err


def test_demo_with_panel_refuses_what_it_cannot_obey(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demo", "--panel", "--hide", "3"]) == 1
    assert "--panel runs until Ctrl-C" in capsys.readouterr().err
