"""From the search to what is said: named, none or unexplained, with the numbers behind it."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from stillarm.common.causes import CAUSES as CATALOGUE
from stillarm.diagnosis.candidate import Candidate, Found, Stage
from stillarm.diagnosis.catalogue import CAUSES
from stillarm.diagnosis.cause import Values
from stillarm.diagnosis.choice import confidence, inseparable
from stillarm.diagnosis.experiments import experiment
from stillarm.diagnosis.fit import Data, Fit, Split, least_level, make_data
from stillarm.diagnosis.reach import reach_of
from stillarm.diagnosis.residuals import noise_floor
from stillarm.diagnosis.scatter import ENCODER
from stillarm.diagnosis.side_by_side import meanwhile
from stillarm.diagnosis.structure import Remains, Structure, examine
from stillarm.diagnosis.unpredictable import predictable

Array = NDArray[np.float64]

_SHARE_LEFT = 0.15  # of what the findings gain, held out
_LEAD_NATS = 5.0  # how much likelier a name is than any one term, before any data
_BOUND = 6.0  # deviations
_BY_CHANCE = 3.0  # nats
_LIKENESS = 0.3  # a cause that a term without a name beats
_CHANNEL_OF_LAWS = {"accelerometer": "acceleration", "timing": "arrival"}


@dataclass(frozen=True)
class Judged:
    """The verdict with its structures before and after, per channel.

    left: what remains after all findings, if that is much. unnamed_lead: nats by which a term, or where something is
    left a law, without a name does better than the first finding; above zero, the finding is at most a likeness.
    named: probability that it is the first finding rather than the best term.
    """

    verdict: str
    before: dict[str, Structure]
    after: dict[str, Structure]
    left: Structure | None
    unnamed_lead: float = 0.0
    left_nats: float = 0.0
    named: float = 1.0


def judge(found: Found, split: Split) -> Judged:
    """Whether significant structure remains after all findings, or a term without a name beats them."""
    after = (
        meanwhile(examine, make_data(found.final.world, split), found.final, found.known_laws)
        if found.findings
        else None
    )
    first = examine(make_data(found.baseline.world, split), found.baseline)
    last = first if after is None else after.result()
    worst = last.worst
    named = [one for one in found.findings if one.law is None]
    gained = sum(max(one.held_out_gain, 0.0) for one in found.findings)
    left = worst if worst is not None and worst.nats > _SHARE_LEFT * gained else None
    judging = split.held & predictable(split, found.baseline)
    # what was taken first as the data plainly show it may be a small thing beside the others
    main = max(named, key=lambda one: one.gain, default=None)
    ahead = _ahead(main, first, judging) if main else -np.inf
    lead = _beyond_chance(ahead, main) if main else 0.0
    if lead > 0.0 and left is None:
        left = _unnamed(first)
    if main and left is not None:
        lead = max(lead, _lead_of_laws(main, first))
    if not found.findings and left is None:
        left = _too_small(found, first)
    if named and left is None and _too_many(found, named[0]):
        left = first.worst or _unnamed(first)
    verdict = "unexplained" if left is not None else ("named" if found.findings else "none")
    left_nats = left.nats if left is not None and left is worst else 0.0
    probability = float(expit(_LEAD_NATS - ahead))
    return Judged(verdict, first.channels, last.channels, left, lead, left_nats, probability)


def _ahead(one: Candidate, first: Remains, judging: NDArray[np.bool_]) -> float:
    """Nats by which the best term without a name explains more than the finding, as many numbers being fitted.
    judging: held-out blocks that say anything."""
    unnamed = first.terms.first_nats + float(first.terms.first_blocks[judging].sum())
    return unnamed - one.gain


def _beyond_chance(ahead: float, one: Candidate) -> float:
    """A lead over the finding; zero if it may be chance."""
    return ahead if ahead > _LEAD_NATS + 0.01 * one.gain else 0.0


def _lead_of_laws(one: Candidate, first: Remains) -> float:
    """The same of laws without a name: where one goes on explaining what is left, and explained more than the finding
    did before there was any, the finding may be but the part of it that has a name."""
    return _beyond_chance(
        max(law.train_log_likelihood + law.nats for law in first.channels.values()) - one.gain, one
    )


def _too_many(found: Found, one: Candidate) -> bool:
    """Whether the first finding is one of three or more that the data cannot tell apart: no name is known then."""
    stage = next(stage for stage in found.stages if stage.taken is one)
    return len(inseparable(stage)) > 1


def _too_small(found: Found, first: Remains) -> Structure | None:
    """What looks like a cause, but too small a one to have a name, as a structure that is left in its channel; but for
    an encoder's, whose rounding does as much."""
    one = next((stage.too_small for stage in found.stages if stage.too_small is not None), None)
    if one is None:
        return None
    likeness = f"like {one.cause}, of a size too small to have a name"
    left = _channel_mended(found.baseline, one.fit)
    if left in ENCODER:
        return None
    return replace(
        first.channels[left], white=False, nats=one.held_out_gain, std_nats=one.held_out_std,
        train_log_likelihood=one.train_gain, dependence=likeness,
    )  # fmt: skip


def _channel_mended(before: Fit, after: Fit) -> str:
    """The channel of which a fit explains most."""

    def power(one: Fit, name: str) -> float:
        return float(np.nansum(np.minimum(np.abs(one.residuals[name] / before.sigma[name]), _BOUND) ** 2))

    return max(before.residuals, key=lambda name: power(before, name) - power(after, name))


def _unnamed(first: Remains) -> Structure:
    """The channel of the term without a name, as a structure that is left."""
    shown = [one for one in first.channels.values() if one.dependence in first.terms.names[:1]]
    return shown[0] if shown else max(first.channels.values(), key=lambda one: one.nats)


def sure(one: Candidate, stage: Stage, judged: Judged) -> float:
    """Probability that a finding is right: by its lead over the other causes, and over what has no name."""
    gained = max(one.held_out_gain, 1e-9)
    channel = judged.left.channel if judged.left is not None else None
    # what a wrong simulation leaves looks like noise of another law
    doubtful = one.law is not None and channel == _CHANNEL_OF_LAWS.get(CATALOGUE[one.cause].place)
    likeness = _LIKENESS if judged.unnamed_lead > 0.0 or doubtful else 1.0
    likeness = likeness if one.law is not None else min(likeness, judged.named)
    return likeness * confidence(stage) * gained / (gained + judged.left_nats)


def _error(fit: Fit, data: Data, name: str, judging: NDArray[np.bool_]) -> tuple[float, float, int]:
    """Root mean square of the free-run residual, and the measured channel's deviation, where held out and judging."""
    values = data.world.channels[name]
    mask = data.held[name] & judging[data.blocks[name]]
    mask = mask if mask.any() else data.train[name]
    residual = values[mask] - fit.predicted.channels[name][mask]
    measured = values[mask]
    if name == "arrival":  # the ramp of time is no variation
        measured = measured - data.world.frame_clock.grid_s[mask]
    spread = (
        max(float(np.std(measured)), least_level(data.world, name)) or 1.0
    )  # exact stamps do not vary at all
    return float(np.sqrt(np.mean(residual**2))), spread, int(mask.sum())


def channel_table(found: Found, judged: Judged, split: Split) -> dict[str, dict[str, Any]]:
    """Per channel: samples, held-out errors before and after, noise floor, whether white."""
    first, last = make_data(found.baseline.world, split), make_data(found.final.world, split)
    judging = predictable(split, found.baseline, found.final)
    table = {}
    for name in found.final.world.channels:
        before, spread, count = _error(found.baseline, first, name, judging)
        after, _, _ = _error(found.final, last, name, judging)
        table[name] = {
            "samples": count,
            "nrmse_before": before / spread,
            "nrmse_after": after / spread,
            "noise_floor": noise_floor(found.final.residuals[name]) / spread,
            "white_before": judged.before[name].white,
            "white_after": judged.after[name].white,
        }
    return table


_HARDLY = 0.2


def is_sure_of(finding: dict[str, Any], table: dict[str, Any]) -> bool:
    """Whether a finding may be put forward: not where structure is left that dwarfs it."""
    return bool(table["verdict"] != "unexplained" or finding["confidence"] >= _HARDLY)


def findings(found: Found, judged: Judged, split: Split) -> list[dict[str, Any]]:
    """The findings as diagnosis.json has them."""
    listed = []
    previous = found.baseline
    for one in found.findings:
        stage = next(stage for stage in found.stages if stage.taken is one)
        near = inseparable(stage)
        values = one.values
        if one.law is None:
            values = _known(one, found.final, split)
        origin = found.final.world.measured.origin_s
        listed.append(
            {
                "cause": one.cause,
                "confidence": sure(one, stage, judged) / (1 + len(near)),
                "parameters": {
                    name: {"value": value + (origin if name == "onset_s" else 0.0), "std": std}
                    for name, (value, std) in values.items()
                },
                "held_out": _held_out(one, previous, split),
                "indistinguishable_from": near,
                "experiment": experiment(one.cause, near) if near else None,
                "note": one.note or None,
            }
        )
        if one.law is None:
            previous = one.fit
    return listed


def _known(one: Candidate, final: Fit, split: Split) -> Values:
    """A finding's parameters by the last fit, an onset's and a threshold's deviations as they were searched for."""
    cause = CAUSES[one.cause]
    values = cause.parameters_of(final)
    if "onset_s" in values:
        values["onset_s"] = (values["onset_s"][0], one.values["onset_s"][1])
    for quantity, reach in reach_of(final, cause, split).items():
        name = quantity.split(".")[-1]
        values[name] = (values[name][0], max(values[name][1], reach))
    return values


def _held_out(one: Candidate, previous: Fit, split: Split) -> dict[str, float]:
    """Errors on the held-out part before and after this finding, in the channel that it mends most, by more than chance
    does where the simulation itself may be off by as much as levels are never below."""
    best = (0.0, 1.0, 1.0)
    first, last = make_data(previous.world, split), make_data(one.fit.world, split)
    judging = predictable(split, previous, one.fit)
    for name in previous.world.channels:
        before, spread, count = _error(previous, first, name, judging)
        after, _, _ = _error(one.fit, last, name, judging)
        sigma = max(after, least_level(previous.world, name))
        nats = 0.5 * count * (before**2 - after**2) / sigma**2
        if nats > _BY_CHANCE and 1.0 - after / before > best[0]:
            best = (1.0 - after / before, before / spread, after / spread)
    reduction, before, after = best
    return {
        "nrmse_before": before,
        "nrmse_after": after,
        "reduction": reduction,
        "log_score_gain": one.held_out_gain,
    }


def events(found: Found) -> list[dict[str, Any]]:
    """Blows that no sensor measured, in the recording's own time."""
    measured = found.final.world.measured
    return [
        {"time_s": measured.origin_s + cycle * measured.cycle_s, "kind": "impact"}
        for cycle in found.final.world.impacts
    ]


def unexplained(judged: Judged) -> dict[str, Any] | None:
    """What is known of the structure that remains."""
    left = judged.left
    if left is None:
        return None
    return {
        "channel": left.channel,
        "band_hz": list(left.band_hz),
        "dependence": left.dependence,
        "term": left.term,
    }
