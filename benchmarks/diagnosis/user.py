"""`python -m benchmarks.diagnosis.user`: runs `stillarm` commands, one a line, as a user would, without starting anew.

This process sees a bundle's folder and nothing else: what is hidden in it is known only to the one that asks.
"""

import contextlib
import io
import os
from typing import Any

from benchmarks.diagnosis.warm import serve


def _run(words: list[str]) -> dict[str, Any]:
    """{"problem": None or the last line on standard error, "cpu_s": processor time that the command took}."""
    from stillarm.main import main

    error, before = io.StringIO(), os.times()
    try:
        with contextlib.redirect_stderr(error), contextlib.redirect_stdout(io.StringIO()):
            status = main(words)
    except SystemExit as end:
        status = int(end.code) if isinstance(end.code, int) else 1
    except Exception as fault:  # what a user would see as a traceback is a miss, and its last line is kept
        status = 1
        error.write(f"\n{type(fault).__name__}: {fault}\n")
    after = os.times()
    told = [line for line in error.getvalue().splitlines() if line.strip()]
    return {
        "problem": None if status == 0 else (told[-1] if told else f"exit status {status}"),
        "cpu_s": after.user + after.system - before.user - before.system,
    }


if __name__ == "__main__":
    serve(_run)
