"""`python -m stillarm.benchmarks.diagnosis.user`: runs `stillarm` commands, one per line, as a user would,
without restarts.

This process sees only a bundle's folder. Only the process that asks knows what is hidden in it.
"""

import contextlib
import io
import os
from typing import Any

from stillarm.benchmarks.diagnosis.warm import serve


def _run(words: list[str]) -> dict[str, Any]:
    """{"problem": None or the last line on standard error, "cpu_s": processor time that the command took}."""
    from stillarm.main import main

    error, before = io.StringIO(), os.times()
    try:
        with contextlib.redirect_stderr(error), contextlib.redirect_stdout(io.StringIO()):
            status = main(words)
    except SystemExit as end:
        status = int(end.code) if isinstance(end.code, int) else 1
    except Exception as fault:  # a traceback counts as a miss; its last line is kept
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
