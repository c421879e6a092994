"""What the search hands on: a cause refitted, a step with all its rivals, and the end."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.fit import Fit
from stillarm.diagnosis.laws import LawFound
from stillarm.diagnosis.screen import Screening

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)  # one is itself only: arrays have no truth
class Candidate:
    """A cause refitted. law: set for a law of noise or timing, which changes no fit. certain: the data show it by
    themselves, so that its gain need not be the same in all blocks. block_gains: of each held-out block (a law's: of
    all); train_blocks: of each block's part that trains, empty where unknown."""

    cause: str
    fit: Fit
    train_gain: float
    held_out_gain: float
    held_out_std: float
    block_gains: Array
    values: dict[str, tuple[float, float]]
    law: LawFound | None = None
    free: tuple[str, ...] = ()
    note: str = ""
    prior_penalty: float = 0.0
    certain: bool = False
    train_blocks: Array = field(default_factory=lambda: np.empty(0))
    form: str = ""
    begins: str | None = None
    begins_s: float | None = None
    merit: float = 0.0
    """Nats of the log score by frequency, all blocks, less what its numbers cost."""
    nats: Array = field(default_factory=lambda: np.empty(0))
    """Nats of the log score of each block."""
    parameters_of: Callable[[Fit], dict[str, tuple[float, float]]] | None = None

    @property
    def gain(self) -> float:
        """Nats gained by all data."""
        return self.train_gain + self.held_out_gain

    @property
    def all_block_gains(self) -> Array:
        """Nats gained in each block, of what trains there and what is held out; where train_blocks are known."""
        return self.train_blocks + self.block_gains


@dataclass
class Stage:
    """One step of the search: what was screened, who was refitted (best first), who was taken.

    other_names: causes that a later stage would have added, and that explain the same thing. too_small: one whose gain
    is more than chance, and whose size is too little to have a name.
    """

    screening: Screening
    candidates: list[Candidate]
    taken: Candidate | None
    other_names: list[str] = field(default_factory=list)
    too_small: Candidate | None = None


@dataclass
class Found:
    """The search's end: the fit with all findings, each with its candidates at the time."""

    baseline: Fit
    final: Fit
    findings: list[Candidate] = field(default_factory=list)
    stages: list[Stage] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    """What the time did not suffice for."""

    @property
    def known_laws(self) -> frozenset[str]:
        """Causes among the findings that are laws of noise or timing."""
        return frozenset(one.cause for one in self.findings if one.law is not None)
