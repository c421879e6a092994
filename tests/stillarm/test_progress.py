"""Progress as lines, for whoever reads them from a pipe: each percent once. On a terminal, a first sign at once."""

import io
import json
import subprocess
import sys
from contextlib import redirect_stderr
from pathlib import Path

import cv2
import numpy as np
import pytest

from stillarm.main import COMMANDS
from stillarm.progress import progress_bar, tell_terminal
from tests.fixtures.recordings import some_fast, written

CONFIGS = Path(__file__).parents[2] / "configs"
FIRST_SIGNS = """
import json, os, sys, stillarm.main
HEAVY = ("scipy", "matplotlib", "numba", "cv2", "pandas", "polars", "pyarrow", "h5py")
class Terminal:
    encoding = "utf-8"
    def __init__(self, to): self.to = to
    def isatty(self): return True
    def fileno(self): raise OSError("no file")
    def flush(self): pass
    def write(self, text):
        os.write(self.to, json.dumps([name for name in HEAVY if name in sys.modules]).encode())
        os._exit(0)
found = {}
for name, words in json.loads(sys.argv[1]).items():
    ours, its = os.pipe()
    child = os.fork()
    if child == 0:
        sys.stdout = sys.stderr = Terminal(its)
        stillarm.main.main(words)
        os._exit(1)
    os.close(its)  # a child of the child may hold another
    os.waitpid(child, 0)
    os.set_blocking(ours, False)
    found[name] = json.loads(os.read(ours, 1000) or b'["nothing was written"]')
print(json.dumps(found))
"""


def test_lines_tell_each_percent_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("STILLARM_PROGRESS", "lines")
    with progress_bar("fit") as done:
        for share in (0.001, 0.42, 0.421, 1.0):
            done(share)
    assert capsys.readouterr().err == "progress 0.00 fit\nprogress 0.42 fit\nprogress 1.00 fit\n"


def test_nothing_is_written_to_a_file(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("STILLARM_PROGRESS", raising=False)
    with progress_bar("fit") as done:
        done(0.5)
    assert capsys.readouterr().err == ""


def test_a_terminal_is_told_at_once_and_a_file_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    tell_terminal("rig: loads")
    assert capsys.readouterr().err == ""
    terminal = io.StringIO()
    terminal.isatty = lambda: True  # type: ignore[method-assign]
    with redirect_stderr(terminal):
        tell_terminal("rig: loads")
    assert terminal.getvalue() == "rig: loads\n"


@pytest.mark.slow
def test_nothing_heavy_is_loaded_before_a_command_s_first_sign_of_life(tmp_path: Path) -> None:
    """Loading it takes a second and more, in which a user would see nothing. Only a video is opened first."""
    (tmp_path / "rec.mcap").write_bytes(written(some_fast(300)))
    (tmp_path / "bundle").mkdir()
    (tmp_path / "bundle" / "fast.csv").write_text("time_s,acceleration_m_s2\n0.0,0.1\n0.001,0.2\n")
    (tmp_path / "frames").mkdir()
    for number in range(3):
        cv2.imwrite(str(tmp_path / "frames" / f"{number}.png"), np.zeros((64, 64), np.uint8))
    model, config = CONFIGS / "model.toml", CONFIGS / "simulated_rig.toml"
    words = {
        **dict.fromkeys(("controller", "supervisor", "rig", "check"), f"--config {config}"),
        "demo": "--out demo",
        "panel": "--recordings . --port 0",
        "operate": f"stop --config {config}",
        "commission": f"--config {config} -o found.toml",
        "simulate": f"--model {model} -o simulated.mcap",
        "replay": "rec.mcap",
        "recover": "rec.mcap",
        "diagnose": "rec.mcap",
        "calibrate": f"rec.mcap --model {model} -o new.toml",
        "export": "rec.mcap -o tables",
        "import": "bundle/fast.csv --look",
        "track": "frames --rate-hz 65 -o frames.csv",
        "causes": "",
        "completion": "bash",
        "latency": "",
        "benchmark": "live",
    }
    assert set(words) == set(COMMANDS)
    given = json.dumps({name: [name, *text.split()] for name, text in words.items()})
    words_of_python = [sys.executable, "-c", FIRST_SIGNS, given]
    done = subprocess.run(
        words_of_python,
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=120,
    )
    assert json.loads(done.stdout) == {name: ["cv2"] if name == "track" else [] for name in words}
