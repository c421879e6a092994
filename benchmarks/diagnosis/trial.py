"""`python -m stillarm.benchmarks.diagnosis.trial`: makes, asks and marks one trial per line: [kind, number,
seed] to a row."""

import shutil
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from stillarm.benchmarks.diagnosis.ask import ask
from stillarm.benchmarks.diagnosis.hidden import Prepare, hidden_world
from stillarm.benchmarks.diagnosis.mark import mark
from stillarm.benchmarks.diagnosis.warm import Warm, serve

Ask = Callable[[Path, Path], dict[str, Any]]


def trial(kind: str, number: int, seed: int, prepare: Prepare, answer: Ask) -> dict[str, Any]:
    """One trial's row. The bundle's folder always has the same name, and is removed afterwards."""
    work = Path(tempfile.mkdtemp(prefix="stillarm_trial_"))
    began = time.process_time()
    try:
        truth = prepare(kind, number, seed, work / "data") | {"number": number}
        making_s = time.process_time() - began
        return mark(truth, answer(work / "data", work)) | {"making_cpu_s": making_s}
    finally:
        shutil.rmtree(work, ignore_errors=True)


def main() -> None:
    """Answer until standard input ends."""
    with Warm("stillarm.benchmarks.diagnosis.user") as user:
        prepare = hidden_world()

        def row(question: list[Any]) -> dict[str, Any]:
            kind, number, seed = question
            return trial(kind, number, seed, prepare, partial(ask, user=user))

        serve(row)


if __name__ == "__main__":
    main()
