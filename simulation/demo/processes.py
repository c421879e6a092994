"""Starts, watches and stops the demo's processes. Each writes its output to a log of its own."""

import subprocess
import time
from collections.abc import Callable
from pathlib import Path

from stillarm.common.process.child_process import start_module, stop_process
from stillarm.common.process.parent_death import ended_with_parent
from stillarm.common.user_error import UserError

_STOP_WITHIN_S = 15.0
_POLL_S = 0.1


class DemoProcesses:
    """Operating-system processes of `stillarm`, by name."""

    def __init__(self, directory: Path) -> None:
        """Logs go to `directory`/NAME.log."""
        self._directory = directory
        self._running: dict[str, subprocess.Popen[bytes]] = {}

    def start(self, name: str, *arguments: str) -> None:
        """Start `stillarm NAME ARGUMENTS`; it ends when this process does, killed or not."""
        with self._log(name).open("wb") as log:
            self._running[name] = start_module(
                "stillarm",
                name,
                *arguments,
                stdout=log,
                stderr=subprocess.STDOUT,
                preexec_fn=ended_with_parent(),  # no thread runs yet, and it calls the kernel only
            )

    def process_id(self, name: str) -> int:
        """The process number of one that was started."""
        return self._running[name].pid

    def wait_for(self, name: str, timeout_s: float, progress: Callable[[float], None]) -> None:
        """Wait until a process has ended, while the others run on.

        progress: told the seconds that have passed. Raises UserError, with the last words of the process that failed.
        """
        started = time.monotonic()
        while self._running[name].poll() is None:
            self.check()
            passed = time.monotonic() - started
            if passed > timeout_s:
                raise UserError(
                    f"the demo's {name} did not end within {timeout_s:.0f} s; see {self._log(name)}"
                )
            progress(passed)
            time.sleep(_POLL_S)
        self.check()

    def check(self) -> None:
        """Raise UserError if a process has failed, or ended that should run on."""
        for name, process in self._running.items():
            status = process.poll()
            if status is not None and (status != 0 or name != "controller"):
                raise UserError(f"the demo's {name} ended (status {status}): {self._last_words(name)}")

    def process_ids(self) -> dict[str, int]:
        """The processes' numbers, by name."""
        return {name: process.pid for name, process in self._running.items()}

    def stop(self, name: str) -> None:
        """Ask a process to stop, and wait for it; kill it when it does not."""
        process = self._running.pop(name, None)
        if process is not None:
            stop_process(process, _STOP_WITHIN_S)

    def stop_all(self) -> None:
        """Stop the running processes, the controller first."""
        for name in ("controller", "supervisor", "rig"):
            self.stop(name)

    def _log(self, name: str) -> Path:
        return self._directory / f"{name}.log"

    def _last_words(self, name: str) -> str:
        lines = self._log(name).read_text(errors="replace").strip().splitlines()
        return lines[-1] if lines else "it said nothing"
