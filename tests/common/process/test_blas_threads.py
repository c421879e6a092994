"""One thread for linear algebra, set in time and only where the environment leaves it open."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from stillarm.common.process.blas_threads import BLAS_THREADS, one_blas_thread


def test_what_the_environment_says_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    first, *others = BLAS_THREADS
    monkeypatch.setenv(first, "4")
    for name in others:
        monkeypatch.delenv(name)
    one_blas_thread()
    assert [os.environ[name] for name in BLAS_THREADS] == ["4", "1", "1"]


@pytest.mark.slow
def test_it_comes_before_numpy() -> None:
    """Importing it, and the commands that call it, loads no numpy: the variables would come too late."""
    commands = [
        f"stillarm.commands.{name}_command"
        for name in ("recordings.calibrate", "rig.controller", "recordings.diagnose", "measuring.latency")
    ]
    text = f"import sys, stillarm.common.process.blas_threads, {', '.join(commands)}; print('numpy' in sys.modules)"
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parents[3])}
    done = subprocess.run(
        [sys.executable, "-c", text], capture_output=True, text=True, check=True, env=environment
    )
    assert done.stdout == "False\n"
