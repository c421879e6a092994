"""Starts Python processes of this program from any working directory, and ends them."""

import os
import selectors
import subprocess
import sys
from pathlib import Path
from typing import Any

import stillarm

_ROOT = Path(stillarm.__file__).parents[1]


def module_command(module: str, *words: str) -> tuple[list[str], dict[str, str]]:
    """Command and environment of `python -m MODULE WORDS` with this program's packages in its path."""
    search = os.pathsep.join([str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    # -P: a folder named 'stillarm' where the user happens to stand must not take this package's place
    return [sys.executable, "-P", "-m", module, *words], {**os.environ, "PYTHONPATH": search}


def start_module(module: str, *words: str, **how: Any) -> subprocess.Popen[bytes]:
    """Start `python -m MODULE WORDS` with this program's packages in its path. how: more of Popen's arguments."""
    command, environment = module_command(module, *words)
    return subprocess.Popen(command, env=environment, **how)


def next_line(process: subprocess.Popen[bytes], within_s: float) -> str | None:
    """The next line that a process prints to its pipe; "" where it ended instead, None where nothing came in time.

    For lines that come one at a time, each after something was asked of the process.
    """
    assert process.stdout is not None
    with selectors.DefaultSelector() as selector:
        selector.register(process.stdout, selectors.EVENT_READ)
        if not selector.select(within_s):
            return None
    return process.stdout.readline().decode(errors="replace").strip()


def stop_process(process: subprocess.Popen[bytes], within_s: float) -> None:
    """Ask it to end (SIGTERM) and wait; kill it where it does not. May be called twice."""
    process.terminate()
    try:
        process.wait(within_s)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
