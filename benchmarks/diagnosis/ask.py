"""What a user would do with a bundle of measured data: `stillarm import`, then `stillarm diagnose`, each on its own."""

import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

_LONGEST_S = 600.0


def ask(bundle: Path, work: Path, hold_out: list[list[float]]) -> dict[str, Any]:
    """{"seconds", "answer": the content of diagnosis.json, or None and "error"} for a bundle; `work` takes the files.

    hold_out: [from, to] in s, chosen by the judge, so that the gain can be held against the true model's on the same
    samples. seconds: wall clock of `stillarm diagnose` alone, from cold.
    """
    recording, out = work / "recording.mcap", work / "out"
    problem = _stillarm("import", str(bundle), "-o", str(recording))
    if problem is not None:
        return {"seconds": None, "answer": None, "error": f"import: {problem}"}
    began = time.perf_counter()
    windows = [word for begin, end in hold_out for word in ("--hold-out", f"{begin}:{end}")]
    problem = _stillarm("diagnose", str(recording), "--out", str(out), *windows)
    seconds = time.perf_counter() - began
    if problem is not None:
        return {"seconds": seconds, "answer": None, "error": f"diagnose: {problem}"}
    try:
        answer = json.loads((out / "diagnosis.json").read_text())
    except (OSError, ValueError) as error:
        return {"seconds": seconds, "answer": None, "error": f"diagnosis.json: {error}"}
    return {"seconds": seconds, "answer": answer, "error": None}


def _stillarm(*arguments: str) -> str | None:
    """None if it succeeded, else its last line on standard error."""
    try:
        done = subprocess.run(
            [sys.executable, "-m", "stillarm", *arguments],
            capture_output=True,
            text=True,
            timeout=_LONGEST_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"no answer within {_LONGEST_S:.0f} s"
    if done.returncode == 0:
        return None
    lines = done.stderr.strip().splitlines()
    return lines[-1] if lines else f"exit status {done.returncode}"
