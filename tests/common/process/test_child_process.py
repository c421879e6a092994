"""A child process is found from any working directory, and has ended after it was stopped."""

import subprocess
import sys
from pathlib import Path

import pytest

from stillarm.common.process.child_process import start_module, stop_process

pytestmark = pytest.mark.slow


def test_what_lies_where_the_user_stands_takes_no_package_s_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And what PYTHONPATH names is still found, behind the program's own."""
    for name, place in (("common", tmp_path / "here"), ("common", tmp_path / "named")):
        (place / name).mkdir(parents=True)
        (place / name / "__init__.py").write_text("raise SystemExit('the wrong one')\n")
    asked = tmp_path / "named" / "asked_by_test.py"
    asked.write_text(
        "import sys, stillarm.common.user_error as found; print(found.__file__, *sys.argv[1:])\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "named"))
    process = start_module("asked_by_test", "a", "b", cwd=tmp_path / "here", stdout=subprocess.PIPE)
    said, _ = process.communicate(timeout=60.0)
    own = Path(__file__).resolve().parents[3] / "stillarm" / "common" / "user_error.py"
    assert process.returncode == 0
    assert said.decode().split() == [str(own), "a", "b"]


@pytest.mark.parametrize(("answer", "within_s", "status"), [("SIG_DFL", 60.0, -15), ("SIG_IGN", 0.05, -9)])
def test_it_ends_when_asked_and_is_killed_where_it_does_not(
    answer: str, within_s: float, status: int
) -> None:
    script = (
        f"import signal, time; signal.signal(signal.SIGTERM, signal.{answer})\n"
        "print('ready', flush=True); time.sleep(60)"
    )
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE)
    assert process.stdout is not None
    with process.stdout as said:
        assert said.readline() == b"ready\n"
    stop_process(process, within_s)
    assert process.returncode == status
    stop_process(process, within_s)
    assert process.returncode == status
