"""A diagnosis from Python, for researchers: one call, and what it found with types, sentences and a figure.

import stillarm
found = stillarm.diagnose("rec.mcap")
found.plot().savefig("evidence.png")
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stillarm.common.files.model import Model
    from stillarm.diagnosis.driven.diagnosed import DrivenResult
    from stillarm.diagnosis.report.result import Result

Verdict = Literal["named", "none", "unexplained"]


@dataclass(frozen=True)
class Estimate:
    """A parameter of a cause, in the unit that its name ends in, with its standard deviation."""

    value: float
    std: float


@dataclass(frozen=True)
class Finding:
    """A cause that was found. confidence: 0 to 1. form: of the mechanism, where it is not the declared one. begins_s:
    in the recording's own time, where it does not act throughout. indistinguishable_from: other causes that explain
    the recording as well, and experiment: what to record to tell them apart."""

    cause: str
    confidence: float
    parameters: dict[str, Estimate]
    form: str | None
    begins_s: float | None
    indistinguishable_from: tuple[str, ...]
    experiment: str | None


@dataclass(frozen=True)
class Diagnosis:
    """What a recording shows that the simulation does not. result: all of it, with the fits (docs/diagnosis.md)."""

    result: "Result | DrivenResult"

    @property
    def verdict(self) -> Verdict:
        """Whether a cause has a name, nothing is left that matters, or what is left has no name."""
        verdict: Verdict = self.result.table["verdict"]
        return verdict

    @cached_property
    def summary(self) -> tuple[str, str, str]:
        """What is wrong, how sure that is, and what to do about it: a sentence each."""
        from stillarm.diagnosis.driven import diagnosed, page
        from stillarm.diagnosis.report.summary import summary

        if isinstance(self.result, diagnosed.DrivenResult):
            return page.sentences(self.result)
        return summary(self.result)

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """Causes in the order in which they were found: the first explains most."""
        return tuple(_finding(one) for one in self.result.table["findings"])

    @property
    def table(self) -> dict[str, Any]:
        """What `stillarm diagnose` writes to diagnosis.json."""
        return self.result.table

    @property
    def extended(self) -> "Model":
        """The model, refitted and with the effects that were found."""
        return self.result.extended

    @property
    def extended_toml(self) -> str:
        """The same as the text of a model file."""
        from stillarm.diagnosis.report.extended_model import model_text

        return model_text(self.result.extended)

    def plot(self, finding: int = 0) -> "Figure":
        """The main evidence, as the report draws it: for a finding, by its number, what betrays its cause; where
        nothing has a name, the spectrum of the residual; beside it measured and simulated. Raises IndexError."""
        from stillarm.diagnosis.driven import diagnosed, page
        from stillarm.diagnosis.report.drawing import figure
        from stillarm.diagnosis.report.picture import main_picture

        if isinstance(self.result, diagnosed.DrivenResult):
            return page.main_figure(self.result)
        return figure(main_picture(self.result, finding))

    def __repr__(self) -> str:
        causes = ", ".join(f"{one.cause} ({one.confidence:.2f})" for one in self.findings)
        return f"<Diagnosis: {self.verdict}{f': {causes}' if causes else ''}>"


def diagnose(
    recording: str | Path,
    *,
    model: "str | Path | Model | None" = None,
    hold_out: Sequence[tuple[float, float]] = (),
    budget_s: float | None = 60.0,
    progress: Callable[[float, str], None] = lambda done, what: None,
) -> Diagnosis:
    """Diagnose a recording (MCAP), as `stillarm diagnose` does. Raises UserError where it holds too little.

    model: a model file, or the model itself; default: the recording's own. hold_out: spans, s, in the recording's own
    time, that no fit sees. budget_s: time for the verdict, s; None: as long as it needs, so that the result does not
    depend on the machine. progress: receives the fraction done, 0 to 1, and the stage.
    """
    began_s = time.monotonic()
    from threadpoolctl import threadpool_limits

    from stillarm.common.files.model import load_model
    from stillarm.diagnosis.decision.budget import Budget
    from stillarm.diagnosis.diagnose import diagnose as result_of

    known = load_model(model) if isinstance(model, str | Path) else model
    # numpy may be loaded already, with a thread for each processor: beside the copies that share out the work, they
    # would wait for each other, ten times as long as the work takes
    with threadpool_limits(1, "blas"):
        return Diagnosis(result_of(recording, known, hold_out, progress, Budget(budget_s, began_s)))


def _finding(row: dict[str, Any]) -> Finding:
    return Finding(
        row["cause"],
        row["confidence"],
        {name: Estimate(one["value"], one["std"]) for name, one in row["parameters"].items()},
        row["form"],
        row["begins_s"],
        tuple(row["indistinguishable_from"]),
        row["experiment"],
    )


__all__ = ["Diagnosis", "Estimate", "Finding", "diagnose"]
