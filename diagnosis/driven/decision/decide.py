"""The verdict on a driven joint: which of what the search took is needed, what else explains it as well, what is left.

The rules are those of docs/diagnosis.md. What was taken early may be made up for by what came later; so each form is
taken out of the final model once more, and what the others cannot make up for is what it is worth.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import exp, inf

from stillarm.diagnosis.data.noise import MATTERS_OF_NOISE
from stillarm.diagnosis.driven.decision.mended import mended_most, share_mended
from stillarm.diagnosis.driven.decision.plainest import plainest
from stillarm.diagnosis.driven.decision.quantised import beyond_half_a_step, quantised
from stillarm.diagnosis.driven.decision.single import one_for_two
from stillarm.diagnosis.driven.fitting.fitting import DrivenFit
from stillarm.diagnosis.driven.mechanisms.mechanisms import STRUCTURE, Form
from stillarm.diagnosis.driven.recording.own import recording_of
from stillarm.diagnosis.driven.search.judging import (
    BESIDE_SHARE,
    CONVINCES,
    NEAR_NATS,
    NEAR_SHARE,
    PRICE,
    Tried,
    judged,
)
from stillarm.diagnosis.driven.search.removal import without_form
from stillarm.diagnosis.driven.search.rests import Rest, rest_of
from stillarm.diagnosis.driven.search.search import Searched, holds_in

SHARE_TO_NAME = 0.35  # of what all findings gain
LEAST_OF_NOISE = 0.15  # of a channel's residual that a finding takes away
# of play, and beside an encoder's steps: impacts that fall to one sample or the next fit some noise, and so do numbers
# that make up for some of what rounding leaves. They must matter
LEAST_OF_ROUGH = MATTERS_OF_NOISE
_MOST_CONFIDENCE = 0.99  # the most that is stated, whatever the odds


@dataclass(frozen=True)
class DrivenFinding:
    """form: as taken. merit: nats that the final model loses without it, less the price. without: the fit that lacks
    it. near: other causes that do as well. reduction: of the held-out error in the channel that it mends most."""

    form: Form
    merit: float
    without: DrivenFit
    near: tuple[str, ...]
    confidence: float
    channel: str
    reduction: float
    own: dict[str, float] = field(default_factory=dict)
    """Numbers that are none of the simulation's."""


@dataclass(frozen=True)
class Verdict:
    """verdict: named, none or unexplained. final: the model with what is needed."""

    verdict: str
    findings: tuple[DrivenFinding, ...]
    rests: tuple[Rest, ...]
    final: DrivenFit


def decide(found: Searched, left_s: Callable[[], float] = lambda: inf) -> Verdict:
    """Judge what the search took."""
    found = one_for_two(plainest(found, left_s), left_s)
    taken = [one.taken for one in found.rounds]
    forms = [one.form for one in taken]
    final = found.final
    steps = quantised(final)
    needed: list[tuple[Tried, float, DrivenFit]] = []
    for one in [other for other in taken if other.form.cause != STRUCTURE]:
        without = without_form(final, one.form, forms, found.start.numbers)
        worth = judged(one.form, final, without).merit if left_s() > 0.0 else one.merit
        if steps is not None:
            fits = (beyond_half_a_step(each, steps[1]) for each in (final, without))
            worth = min(worth, judged(one.form, *fits).merit)
        least = LEAST_OF_ROUGH if one.form.play or steps is not None else LEAST_OF_NOISE
        if worth >= CONVINCES and share_mended(one.form, *_where(one.form, without, final)) >= least:
            needed.append((one, worth, without))
    of_cause = {one.form.cause: 0.0 for one, _, _ in needed}
    for one, worth, _ in needed:
        of_cause[one.form.cause] += worth
    needed.sort(key=lambda one: (-of_cause[one[0].form.cause], -one[1]))
    needed = [one for one in needed if one[1] >= BESIDE_SHARE * max(other[1] for other in needed)]
    rests = tuple(rest_of(final, one.name) for one in final.box.driven.outputs)
    findings = tuple(_finding(one, worth, without, found, final) for one, worth, without in needed)
    if steps is not None:
        form, channel, size, reduction = steps
        findings += (
            DrivenFinding(form, CONVINCES, final, (), _MOST_CONFIDENCE, channel, reduction, {"step": size}),
        )
    total = sum(one.merit for one in findings)
    first = sum(one.merit for one in findings if one.form.cause == findings[0].form.cause)
    sure = bool(findings) and first >= SHARE_TO_NAME * total and len(findings[0].near) <= 1
    unnamed = "unexplained" if findings or any(one.matters for one in rests) else "none"
    verdict = "named" if sure else unnamed
    return Verdict(verdict, findings, rests, final)


def _finding(
    one: Tried, worth: float, without: DrivenFit, found: Searched, final: DrivenFit
) -> DrivenFinding:
    tried = next(each for each in found.rounds if each.taken is one).tried
    rivals = [
        other
        for other in tried
        if other.form.cause not in (STRUCTURE, one.form.cause) and not holds_in(one.form, other.form)
    ]
    near, behind = [], inf
    for rival in rivals:
        gap = max(one.merit - rival.merit, 0.0)  # one that gained more has not won its odds
        behind = min(behind, gap)
        if gap <= max(NEAR_NATS, NEAR_SHARE * one.merit) and rival.form.cause not in near:
            near.append(rival.form.cause)
    odds = min(behind, worth - CONVINCES + NEAR_NATS)
    confidence = min(_MOST_CONFIDENCE, 1.0 / (1.0 + exp(-max(min(odds, 50.0), -50.0) / 3.0)))
    channel, _, reduction = mended_most(*_where(one.form, without, final))
    return DrivenFinding(
        one.form, worth, without, tuple(near), confidence / (1 + len(near)), channel, reduction
    )


def _where(form: Form, *fits: DrivenFit) -> tuple[DrivenFit, ...]:
    """The fits where a form holds: of several recordings the one that has its numbers for itself."""
    recording = recording_of(form.numbers[0])
    return fits if recording is None else tuple(one.part(recording) for one in fits)


__all__ = ["PRICE", "DrivenFinding", "Rest", "Verdict", "decide", "rest_of"]
