"""Cases that others wrote to a folder, answered as a user would answer them, by as many processes as one starts.

    python -m stillarm.benchmarks.diagnosis.cases CASES RESULTS [--budget-s S]
    python -m stillarm.benchmarks.diagnosis.reliability CASES RESULTS [--picture FILE]

CASES: a folder of bundles case_*, such as `python -m tests.hidden_world.rigs.write CASES --count 40 --seed S` writes
them. RESULTS/case_*/diagnosis.json is what `stillarm diagnose` says of each. Several processes may run on the same
RESULTS side by side: each takes the cases that no other has begun.
"""

import argparse
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

BUDGET_S = 60.0
Answer = Callable[[Path, Path, float], str]
"""Diagnoses a case (its folder) into a folder, within a budget in s; returns what was said."""


def stillarm(*arguments: Path | str) -> str:
    """Run the command; returns the first line that it printed, on standard output or else on standard error."""
    done = subprocess.run(
        [sys.executable, "-m", "stillarm", *map(str, arguments)], capture_output=True, text=True, check=False
    )
    return (done.stdout or done.stderr).splitlines()[0] if done.stdout or done.stderr else ""


def once(answer: Answer, case: Path, folder: Path, budget_s: float) -> str | None:
    """Diagnose a case into a folder; returns what was said, None where another process has begun it."""
    try:
        folder.mkdir(parents=True)
    except FileExistsError:
        return None
    return answer(case, folder, budget_s)


def bundle(case: Path, folder: Path, budget_s: float) -> str:
    """Import and diagnose a bundle, which brings its model."""
    recording = folder / "recording.mcap"
    told = stillarm("import", case, "-o", recording)
    if not recording.is_file():
        return told
    said = stillarm("diagnose", recording, "--no-use", "--budget-s", str(budget_s), "--out", folder)
    recording.unlink()  # a megabyte for each second
    return said


def answer_all(answer: Answer, writer: str, arguments: list[str] | None = None) -> None:
    """Answer every case of a folder. writer: module that writes such cases. Ends the process where there is none."""
    parser = argparse.ArgumentParser(description="Diagnoses every case of a folder.")
    parser.add_argument("cases", type=Path, metavar="CASES")
    parser.add_argument("results", type=Path, metavar="RESULTS")
    parser.add_argument("--budget-s", type=float, default=BUDGET_S, metavar="S")
    given = parser.parse_args(arguments)
    cases = sorted(given.cases.glob("case_*"))
    if not cases:
        raise SystemExit(f"{given.cases}: holds no case_*; write some with python -m {writer}")
    for case in cases:
        said = once(answer, case, given.results / case.name, given.budget_s)
        if said is not None:
            print(f"{case.name}: {said}", flush=True)


if __name__ == "__main__":
    answer_all(bundle, "tests.hidden_world.rigs.write")
