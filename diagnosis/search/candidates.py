"""What the search hands on: a cause refitted, a step with its rivals, the end."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.common.causes import CAUSES as DECLARED
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.evidence import CONVINCING_NATS, PRICE_NATS, Score
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.search.screen import Scored
from stillarm.diagnosis.sensors.laws import LawFound

Array = NDArray[np.float64]

EXPLAINED = 0.35
"""Of the nats that a perfect model would gain: half of what is explainable, less what each form's formula and the rig's
own discrepancy keep from being explained."""


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
    gains: Mapping[str, float] = field(default_factory=dict)
    """The same in each channel; none of a law."""
    parameters_of: Callable[[Fit], dict[str, tuple[float, float]]] | None = None


@dataclass
class Stage:
    """One step of the search: what was screened, who was refitted (best first), who was taken."""

    screening: list[Scored]
    candidates: list[Candidate]
    taken: Candidate | None


@dataclass(frozen=True)
class Hint:
    """A round beside another baseline, in which something was taken. struck: the baseline differs by the impacts alone
    that what was taken bears out."""

    baseline: Fit
    stage: Stage
    struck: bool = False

    @property
    def taken(self) -> Candidate:
        """What was taken."""
        assert self.stage.taken is not None
        return self.stage.taken


@dataclass
class Found:
    """The search's end: the fit with all findings, each with its candidates at the time."""

    baseline: Fit
    final: Fit
    findings: list[Candidate] = field(default_factory=list)
    stages: list[Stage] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    """What the time did not suffice for."""
    laws: tuple[Fit, list[LawFound]] | None = None
    """The last laws that were looked for, and the fit on which."""
    likelier: Fit | None = None
    """A likelier baseline that a round came upon: the search is to begin again from there."""
    hint: Hint | None = None
    """What was found beside another baseline: it is fitted before any other form, as that one's time is spent."""

    @property
    def taken(self) -> list[Candidate]:
        """What the rounds took, laws aside, in their order."""
        taken = [stage.taken for stage in self.stages if stage.taken is not None]
        return [one for one in taken if one.law is None]


def of_law(last: Fit, law: LawFound) -> Candidate:
    """A law of noise or timing as a candidate: each block is judged by what the others say already."""
    gains = law.held_out_score
    spread = float(np.std(gains, ddof=1) * sqrt(len(gains)))
    return Candidate(
        law.cause, last, float(gains.sum()), spread, law.values, law, tuple(law.values), law.note,
        merit=float(gains.sum()) - PRICE_NATS * len(law.values), nats=gains,
    )  # fmt: skip


def beside_another(candidates: Sequence[Candidate], first: Score, baseline: Score) -> list[Candidate]:
    """Candidates with their merits over another baseline than the one, `first`, that they were found on."""
    more = first.gain(baseline)
    return [replace(one, nats=one.nats + more, merit=one.merit + float(more.sum())) for one in candidates]


def by_one_measure(candidates: Sequence[Candidate], split: Split) -> list[Candidate]:
    """Candidates, the best first; all by what they foretell of held-out blocks where a free form, which is judged by
    that, would lose to a formula by merit alone, though it leads that one by all blocks and by the held-out ones."""
    ranked = sorted(candidates, key=lambda one: -one.merit)
    best = next((one for one in ranked if one.law is None), None)
    if best is None or not any(_leads(one, best) for one in ranked if one is not best and one.law is None):
        return ranked
    alike = [
        one
        if one.law is not None
        else replace(one, merit=min(one.merit, split.blocks_per_held * one.held_out_gain))
        for one in ranked
    ]
    return sorted(alike, key=lambda one: -one.merit)


def _leads(one: Candidate, best: Candidate) -> bool:
    """Whether a candidate leads one of more merit by all blocks, less what numbers cost, and by those held out."""
    whole = float(one.nats.sum()) - PRICE_NATS * len(one.free)
    return whole > best.merit and one.held_out_gain > best.held_out_gain + CONVINCING_NATS


def shows_most(one: Candidate) -> tuple[str, ...]:
    """The channel in which a candidate gains most; none of a law, which changes no fit."""
    return (max(one.gains, key=lambda name: one.gains[name]),) if one.gains else ()


def explains_the_same(one: Candidate, other: Candidate) -> bool:
    """Whether one candidate explains much of what another does, in the channel in which that one shows most: a mode of
    the arm tells nothing of a clock, however much it tells of the accelerometer."""
    if other.law is not None or one.law is not None:
        return DECLARED[one.cause].place == DECLARED[other.cause].place
    if not (one.gains and other.gains):
        return True
    (channel,) = shows_most(other)
    return one.gains.get(channel, 0.0) >= EXPLAINED * other.gains[channel]


def turns_the_joint(cause: str) -> bool:
    """Whether a cause shows in how the joint moves: all of the drive's but a rotor's imbalance, which shakes the
    arm."""
    return DECLARED[cause].place == "drive" and DECLARED[cause].acts != "force"
