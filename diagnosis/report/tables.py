"""What diagnosis.json holds (contract.md), from what was found and judged."""

from typing import Any

import numpy as np

from stillarm.common.causes import CAUSES, experiment_between
from stillarm.common.causes.declaration import SEPARATES
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.decision.decide import Judged
from stillarm.diagnosis.decision.rival_causes import class_of
from stillarm.diagnosis.fitting.fitted import Fit, least_level, make_data
from stillarm.diagnosis.fitting.rest import Rest
from stillarm.diagnosis.forms.cause import Values
from stillarm.diagnosis.report.residual_tests import autocorrelation
from stillarm.diagnosis.report.residuals import noise_floor
from stillarm.diagnosis.search.candidates import Candidate, Found

NOTHING_LIKE_IT = "nothing that was tried"
_LAGS = 60
_HARDLY = 0.2  # confidence


def channel_table(found: Found, split: Split) -> dict[str, dict[str, Any]]:
    """Per channel: samples, held-out errors before and after, noise floor, whether white."""
    table = {}
    for name in found.final.world.channels:
        before, _, _ = _error(found.baseline, split, name)
        after, spread, count = _error(found.final, split, name)
        table[name] = {
            "samples": count,
            "nrmse_before": before / spread,
            "nrmse_after": after / spread,
            "noise_floor": noise_floor(found.final.residuals[name]) / spread,
            "white_before": _is_white(found.baseline, name),
            "white_after": _is_white(found.final, name),
        }
    return table


def _is_white(one: Fit, name: str) -> bool:
    lags = np.arange(1, min(_LAGS, len(one.residuals[name]) - 1), dtype=np.int64)
    return not autocorrelation(one.residuals[name], lags).significant


def _error(fit: Fit, split: Split, name: str) -> tuple[float, float, int]:
    """Root mean square of the free-run residual where held out, the measured channel's deviation there, and of how many
    samples."""
    data = make_data(fit.world, split)
    values = data.world.channels[name]
    mask = data.held[name] if data.held[name].any() else data.train[name]
    residual = values[mask] - fit.predicted.channels[name][mask]
    measured = values[mask]
    if name == "arrival":  # the ramp of time is no variation
        measured = measured - data.world.frame_clock.grid_s[mask]
    spread = max(float(np.std(measured)), least_level(data.world, name)) or 1.0
    return float(np.sqrt(np.mean(residual**2))), spread, int(mask.sum())


def findings_table(found: Found, judged: Judged, split: Split) -> list[dict[str, Any]]:
    """The findings as diagnosis.json has them."""
    listed = []
    previous = found.baseline
    for one in found.findings:
        near = class_of(found, one)
        origin = found.final.world.measured.origin_s
        values = values_of(one, found.final)
        listed.append(
            {
                "cause": one.cause,
                "form": one.form or None,
                "begins_s": None if one.begins_s is None else origin + one.begins_s,
                "confidence": judged.confidence.get(one.cause, 0.0),
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


def values_of(one: Candidate, final: Fit) -> Values:
    """A finding's parameters by the last fit; of a law as it was found."""
    if one.law is not None or one.parameters_of is None:
        return one.values
    return one.parameters_of(final)


def _held_out(one: Candidate, previous: Fit, split: Split) -> dict[str, float]:
    """Errors on the held-out part before and after this finding, in the channel that it mends most."""
    best = (0.0, 1.0, 1.0)
    for name in previous.world.channels:
        before, spread, _ = _error(previous, split, name)
        after, _, _ = _error(one.fit, split, name)
        if before > least_level(previous.world, name) and 1.0 - after / before > best[0]:
            best = (1.0 - after / before, before / spread, after / spread)
    reduction, before, after = best
    return {
        "nrmse_before": before,
        "nrmse_after": after,
        "reduction": reduction,
        "log_score_gain": one.held_out_gain,
    }


def events_table(found: Found) -> list[dict[str, Any]]:
    """Impacts that no sensor measured, and what held the arm for a while, in the recording's own time."""
    world = found.final.world
    origin, cycle_s = world.measured.origin_s, world.measured.cycle_s
    unjudged = [(start / cycle_s, end / cycle_s) for start, end in world.unjudged_s]
    impacts = [
        {"time_s": origin + cycle * cycle_s, "kind": "impact"}
        for cycle in world.impacts
        if not any(start <= cycle <= end + 2 for start, end in unjudged)
    ]
    pulls = [
        {"time_s": origin + start, "kind": "pull", "released_s": origin + end}
        for start, end in world.unjudged_s
    ]
    return sorted([*impacts, *pulls], key=lambda one: float(str(one["time_s"])))


def unexplained_table(judged: Judged) -> dict[str, Any] | None:
    """The largest departure, where it has no name."""
    if judged.verdict != "unexplained":
        return None
    free = judged.beside or judged.alone
    rest = next((one for one in judged.rests if free is not None and one.channel == free.channel), None)
    rest = rest or judged.left or max(judged.rests, key=lambda one: one.share_of_noise)
    words = free.group.words if free is not None else NOTHING_LIKE_IT
    return {"channel": rest.channel, "band_hz": list(rest.band_hz), "dependence": words, "term": _term(free)}


def _term(free: Any) -> str:
    return f"{free.group.name} ({free.merit:.0f} nats)" if free is not None else ""


def left_table(judged: Judged) -> list[dict[str, Any]]:
    """What remains beside or after the findings, by channel, the largest first."""

    def row(one: Rest) -> dict[str, Any]:
        return {
            "channel": one.channel, "band_hz": list(one.band_hz), "rms": one.rms,
            "share_of_noise": one.share_of_noise, "immaterial": one.immaterial,
        }  # fmt: skip

    return [row(one) for one in sorted(judged.rests, key=lambda one: -one.share_of_noise) if one.rms > 0.0]


def is_sure_of(finding: dict[str, Any], table: dict[str, Any]) -> bool:
    """Whether a finding may be put forward: not where structure is left that dwarfs it."""
    return bool(table["verdict"] != "unexplained" or finding["confidence"] >= _HARDLY)


def experiment(cause: str, near: list[str]) -> str:
    """The recording that separates a cause from those that explain the data as well."""
    known = (experiment_between(cause, other) for other in near)
    return next(filter(None, known), SEPARATES[CAUSES[cause].place])
