"""`python -m tests.hidden_world.driven.score OUT RESULTS`: how many answers are right.

RESULTS/case_0001/diagnosis.json is the answer to OUT/case_0001 (docs/diagnosis.md). Named: the verdict is `named`, and
the first finding is the truth's cause, or a class of at most two that holds it. Nothing hidden: the verdict is `none`.
A case without an answer counts as wrong.
"""

import argparse
import json
from itertools import pairwise
from pathlib import Path
from typing import Any

_SIZES = (3.0, 10.0, 30.0, 101.0)


def right(truth: dict[str, Any], answer: dict[str, Any] | None) -> bool:
    """Whether an answer, as diagnosis.json has it, is right; None: there is none."""
    if answer is None:
        return False
    if truth["expected"] == "none":
        return bool(answer["verdict"] == "none")
    if answer["verdict"] != "named" or not answer["findings"]:
        return False
    first = answer["findings"][0]
    held = {first["cause"], *(first.get("indistinguishable_from") or [])}
    return truth["cause"] in held and len(held) <= 2


def said(answer: dict[str, Any] | None) -> str:
    """An answer in few words."""
    if answer is None:
        return "no answer"
    if answer["verdict"] != "named" or not answer["findings"]:
        return str(answer["verdict"])
    first = answer["findings"][0]
    return " or ".join([first["cause"], *(first.get("indistinguishable_from") or [])])


def score(out: Path, results: Path) -> list[str]:
    """Lines: every miss, then the counts by cause, by size, and of all. Raises SystemExit where OUT holds no case."""
    rows = []
    for file in sorted(out.glob("case_*/truth.json")):
        truth = json.loads(file.read_text())
        answered = results / file.parent.name / "diagnosis.json"
        answer = json.loads(answered.read_text()) if answered.is_file() else None
        rows.append((file.parent.name, truth, answer, right(truth, answer)))
    if not rows:
        raise SystemExit(
            f"score: {out} holds no case_*/truth.json; write some with tests.hidden_world.driven.write"
        )
    lines = [
        f"{name}: {truth['cause'] or 'none'} at {truth['size_in_noise']:.3g} of the noise: {said(answer)}"
        for name, truth, answer, good in rows
        if not good
    ]
    hidden = [(truth, good) for _, truth, _, good in rows if truth["expected"] == "named"]
    for cause in sorted({truth["cause"] for truth, _ in hidden}):
        lines.append(f"{cause:<26} {_counted([good for truth, good in hidden if truth['cause'] == cause])}")
    for low, high in pairwise(_SIZES):
        here = [good for truth, good in hidden if low <= truth["size_in_noise"] < high]
        lines.append(f"{f'{low:g} to {min(high, 100.0):g} deviations':<26} {_counted(here)}")
    clean = [good for _, truth, _, good in rows if truth["expected"] == "none"]
    lines.append(f"{'named':<26} {_counted([good for _, good in hidden])}")
    lines.append(f"{'nothing hidden, none said':<26} {_counted(clean)}")
    return lines


def _counted(good: list[bool]) -> str:
    return f"{sum(good)} of {len(good)}"


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.hidden_world.driven.score", description=__doc__)
    parser.add_argument("out", type=Path, metavar="OUT")
    parser.add_argument("results", type=Path, metavar="RESULTS")
    given = parser.parse_args()
    print("\n".join(score(given.out, given.results)))


if __name__ == "__main__":
    main()
