"""Diagnose a bundle of measured data as a user would: `stillarm import`, then `stillarm diagnose`."""

import json
import time
from pathlib import Path
from typing import Any

from stillarm.benchmarks.diagnosis.warm import Lost, Warm

LONGEST_S = 600.0


def ask(bundle: Path, work: Path, user: Warm) -> dict[str, Any]:
    """Returns {"seconds", "cpu_s", "answer": the content of diagnosis.json, or None and "error"}.

    work: folder for the files. seconds, cpu_s: wall clock and processor time of `stillarm diagnose --no-use`, without
    its imports after the first.
    """
    recording, out = work / "recording.mcap", work / "out"
    imported = _told(user, "import", str(bundle), "-o", str(recording))
    if imported["problem"] is not None:
        return {"seconds": None, "cpu_s": None, "answer": None, "error": f"import: {imported['problem']}"}
    began = time.perf_counter()
    done = _told(user, "diagnose", str(recording), "--no-use", "--out", str(out))
    took = {"seconds": time.perf_counter() - began, "cpu_s": done["cpu_s"]}
    if done["problem"] is not None:
        return took | {"answer": None, "error": f"diagnose: {done['problem']}"}
    try:
        answer = json.loads((out / "diagnosis.json").read_text())
    except (OSError, ValueError) as error:
        return took | {"answer": None, "error": f"diagnosis.json: {error}"}
    return took | {"answer": answer, "error": None}


def _told(user: Warm, *words: str) -> dict[str, Any]:
    try:
        result: dict[str, Any] = user.ask(list(words), LONGEST_S)
    except Lost as lost:
        return {"problem": str(lost), "cpu_s": None}
    return result
