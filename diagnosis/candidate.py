"""What the search hands on: a cause refitted, a step with all its rivals, and the end."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.fit import Fit
from stillarm.diagnosis.laws import LawFound
from stillarm.diagnosis.screen import Scored

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)  # one is itself only: arrays have no truth
class Candidate:
    """A cause refitted. law: set for a law of noise or timing, which changes no fit. held_out_gain: nats of the log
    score by frequency, of the held-out blocks (a law's: of all)."""

    cause: str
    fit: Fit
    held_out_gain: float
    held_out_std: float
    values: dict[str, tuple[float, float]]
    law: LawFound | None = None
    free: tuple[str, ...] = ()
    note: str = ""
    form: str = ""
    begins: str | None = None
    begins_s: float | None = None
    merit: float = 0.0
    """Nats of the log score by frequency, all blocks, less what its numbers cost."""
    nats: Array = field(default_factory=lambda: np.empty(0))
    """Nats of the log score of each block."""
    parameters_of: Callable[[Fit], dict[str, tuple[float, float]]] | None = None


@dataclass
class Stage:
    """One step of the search: what was screened, who was refitted (best first), who was taken."""

    screening: list[Scored]
    candidates: list[Candidate]
    taken: Candidate | None


@dataclass
class Found:
    """The search's end: the fit with all findings, each with its candidates at the time."""

    baseline: Fit
    final: Fit
    findings: list[Candidate] = field(default_factory=list)
    stages: list[Stage] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    """What the time did not suffice for."""
