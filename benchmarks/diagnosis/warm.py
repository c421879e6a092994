"""A persistent process that answers lines of JSON, so that many trials share its imports and compiled code."""

import json
import os
import select
import signal
import subprocess
import sys
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

from stillarm.common.process.blas_threads import BLAS_THREADS

_ONE_THREAD = dict.fromkeys(BLAS_THREADS, "1")


class Lost(Exception):
    """The process died, or did not answer in time. The next question starts another one."""


class Warm:
    """`python -m MODULE`, started by the first question. Not thread-safe."""

    def __init__(self, module: str, own_group: bool = False) -> None:
        """Start nothing yet. module: one that calls `serve`. own_group: Ctrl-C does not reach the process, and its
        children end with it."""
        self._module, self._own_group = module, own_group
        self._process: subprocess.Popen[bytes] | None = None

    def ask(self, question: Any, longest_s: float) -> Any:
        """Ask, and return the answer. Raises Lost."""
        process = self._running()
        assert process.stdin is not None and process.stdout is not None
        try:
            process.stdin.write(json.dumps(question).encode() + b"\n")
            process.stdin.flush()
        except OSError:
            self.close()
            raise Lost("the process has ended") from None
        if not select.select([process.stdout], [], [], longest_s)[0]:
            self.close()
            raise Lost(f"no answer within {longest_s:.0f} s")
        line = process.stdout.readline()
        if not line:
            self.close()
            raise Lost("the process has ended")
        return json.loads(line)

    def close(self) -> None:
        """End the process, if there is one."""
        if self._process is not None:
            if self._own_group:
                os.killpg(self._process.pid, signal.SIGKILL)
            else:
                self._process.kill()
            self._process.communicate()
            self._process = None

    def _running(self) -> subprocess.Popen[bytes]:
        if self._process is None:
            self._process = subprocess.Popen(
                [sys.executable, "-m", self._module],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                env=os.environ | _ONE_THREAD,
                process_group=0 if self._own_group else None,
            )
        return self._process

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def serve(answer: Callable[[Any], Any]) -> None:
    """Inside the process: answer each line until standard input ends. Other output goes to standard error."""
    with os.fdopen(os.dup(1), "w", encoding="utf-8") as out:
        os.dup2(2, 1)
        for line in sys.stdin:
            out.write(json.dumps(answer(json.loads(line))) + "\n")
            out.flush()
