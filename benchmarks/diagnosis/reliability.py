"""How often the first cause that a diagnosis names is right, by the confidence that it states.

    python -m stillarm.benchmarks.diagnosis.reliability CASES RESULTS [CASES RESULTS ...] [--picture FILE]

CASES/case_*/truth.json says what was hidden; RESULTS/case_*/diagnosis.json what was answered. Judged is each first
finding, whatever the verdict: right, if its cause, or one of its class of at most two, was hidden. The expected
calibration error is the mean, over bins weighted by their answers, of |share right - mean confidence| (Naeini, Cooper
and Hauskrecht, "Obtaining well calibrated probabilities using Bayesian binning", AAAI 2015).
"""

import argparse
import json
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from stillarm.benchmarks.diagnosis.summary import wilson
from stillarm.common.user_error import UserError

_EDGES = (0.0, 0.3, 0.5, 0.7, 0.9, 0.97, 1.0)


@dataclass(frozen=True)
class Bin:
    """First findings of a range of confidence. confidence: their mean; right, of: how many."""

    confidence: float
    right: int
    of: int

    @property
    def interval(self) -> list[float]:
        """Wilson's, of the share that is right, 95 %."""
        return wilson(self.right, self.of)


def judged(truth: dict[str, Any], answer: dict[str, Any]) -> tuple[float, bool] | None:
    """The confidence of the first finding, and whether it is right; None without a finding."""
    if not answer.get("findings"):
        return None
    first = answer["findings"][0]
    told = {first["cause"], *(first.get("indistinguishable_from") or [])}
    hidden = {truth["cause"], *truth.get("also", ()), *(one["cause"] for one in truth.get("effects", ()))}
    return float(first["confidence"]), len(told) <= 2 and bool(told & (hidden - {None}))


def bins(findings: Sequence[tuple[float, bool]]) -> list[Bin]:
    """Findings by their confidence."""
    found = []
    for low, high in pairwise(_EDGES):
        here = [(said, right) for said, right in findings if low < said <= high or (said == low == 0.0)]
        if here:
            mean = sum(said for said, _ in here) / len(here)
            found.append(Bin(mean, sum(right for _, right in here), len(here)))
    return found


def expected_calibration_error(found: Sequence[Bin]) -> float:
    """Of all findings."""
    total = sum(one.of for one in found)
    return sum(abs(one.right - one.of * one.confidence) for one in found) / total


def read(cases: Path, results: Path) -> list[tuple[float, bool]]:
    """The first findings of all cases that were answered. Raises UserError where there is none."""
    found = []
    for folder in sorted(cases.glob("case_*")):
        answer = results / folder.name / "diagnosis.json"
        if answer.is_file():
            one = judged(json.loads((folder / "truth.json").read_text()), json.loads(answer.read_text()))
            found += [one] if one is not None else []
    if not found:
        raise UserError(
            f"{results}: names nothing; answer the cases with stillarm.benchmarks.diagnosis.cases"
        )
    return found


def draw(found: Sequence[Bin], path: Path) -> None:
    """The share that is right over the confidence that was stated, with its interval."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.0, 4.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    axes.plot([0.0, 1.0], [0.0, 1.0], color="0.6", label="calibrated")
    for one in found:
        low, high = one.interval
        axes.plot([one.confidence] * 2, [low, high], color="C0")
        axes.plot(one.confidence, one.right / one.of, "o", color="C0")
        words, at = f"{one.right} of {one.of}", (one.confidence, one.right / one.of)
        axes.annotate(words, at, (-8, -4), textcoords="offset points", ha="right", fontsize=9)
    axes.set_xlabel("confidence stated")
    axes.set_ylabel("share of answers that are right, with its 95 % interval")
    axes.set_xlim(0.0, 1.02)
    axes.set_ylim(0.0, 1.02)
    axes.grid(alpha=0.3)
    axes.legend(loc="upper left")
    figure.savefig(path, dpi=110)


def main(arguments: list[str] | None = None) -> None:
    """Print the table and draw it. Raises UserError for folders that are not in pairs."""
    parser = argparse.ArgumentParser(prog="python -m stillarm.benchmarks.diagnosis.reliability")
    parser.add_argument("folders", type=Path, nargs="+", metavar="CASES RESULTS")
    parser.add_argument("--picture", type=Path, metavar="FILE")
    given = parser.parse_args(arguments)
    if len(given.folders) % 2:
        raise UserError("reliability: give folders in pairs: CASES RESULTS [CASES RESULTS ...]")
    pairs = zip(given.folders[::2], given.folders[1::2], strict=True)
    found = bins([one for cases, results in pairs for one in read(cases, results)])
    for one in found:
        low, high = one.interval
        print(
            f"said {one.confidence:.2f}: right {one.right} of {one.of} ({100 * low:.0f} to {100 * high:.0f} %)"
        )
    print(f"expected calibration error {100 * expected_calibration_error(found):.1f} %")
    if given.picture is not None:
        draw(found, given.picture)


if __name__ == "__main__":
    try:
        main()
    except UserError as error:
        raise SystemExit(str(error)) from None
