"""From the search to what is said: named, none or unexplained, with the numbers behind it."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diagnosis.catalogue import CAUSES
from diagnosis.experiments import experiment
from diagnosis.fit import Data, Fit, Split, make_data
from diagnosis.search import Candidate, Found, confidence, inseparable
from diagnosis.structure import Structure, examine

Array = NDArray[np.float64]

_STRUCTURED = 0.03  # of a channel's variance
_SHARE_LEFT = 0.35  # of what the findings explain
_OWN_FORM = 1.5  # a black box that gains so many times more than the cause named


@dataclass(frozen=True)
class Judged:
    """The verdict with its structures before and after, per channel."""

    verdict: str
    before: dict[str, Structure]
    after: dict[str, Structure]
    left: Structure | None


def judge(found: Found, split: Split) -> Judged:
    """Whether significant structure remains after all findings."""
    first, last = make_data(found.baseline.world, split), make_data(found.final.world, split)
    before = {name: examine(first, found.baseline, name) for name in found.baseline.world.channels}
    after = {name: examine(last, found.final, name) for name in found.final.world.channels}
    worst, size = None, 0.0
    by_law = {"impulse_noise": "acceleration", "delay_bursts": "arrival"}
    excused = {by_law[one.cause] for one in found.findings if one.cause in by_law}
    for name, structure in after.items():
        if structure.white or name in excused:
            continue
        significant = structure.nats > max(10.0, 2.5 * structure.std_nats)
        left = max(structure.reduction if significant else 0.0, structure.memory)
        explained = (found.baseline.sigma[name] / found.final.sigma[name]) ** 2 - 1.0
        if left > _STRUCTURED and left > _SHARE_LEFT * max(explained, 0.0) and left > size:
            worst, size = structure, left
    verdict = "unexplained" if worst is not None else ("named" if found.findings else "none")
    return Judged(verdict, before, after, worst)


def _error(fit: Fit, data: Data, name: str) -> tuple[float, float, int]:
    """Root mean square of the free-run residual, and the measured channel's deviation, where held out."""
    values = data.world.channels[name]
    mask = data.held[name] if data.held[name].any() else data.train[name]
    residual = values[mask] - fit.predicted.channels[name][mask]
    measured = values[mask]
    if name == "arrival":  # the ramp of time is no variation
        measured = measured - data.world.frame_clock.grid_s[mask]
    return float(np.sqrt(np.mean(residual**2))), float(np.std(measured)) or 1.0, int(mask.sum())


def _floor(fit: Fit, name: str) -> float:
    """Noise level of a channel from neighbouring residuals: what no model of slow things can go below."""
    residual = fit.residuals[name]
    steps = np.diff(residual[np.isfinite(residual)])
    return 1.4826 * float(np.median(np.abs(steps - np.median(steps)))) / 2.0**0.5 if len(steps) else 0.0


def channel_table(found: Found, judged: Judged, split: Split) -> dict[str, dict[str, Any]]:
    """Per channel: samples, held-out errors before and after, noise floor, whether white."""
    first, last = make_data(found.baseline.world, split), make_data(found.final.world, split)
    table = {}
    for name in found.final.world.channels:
        before, spread, count = _error(found.baseline, first, name)
        after, _, _ = _error(found.final, last, name)
        table[name] = {
            "samples": count,
            "nrmse_before": before / spread,
            "nrmse_after": after / spread,
            "noise_floor": _floor(found.final, name) / spread,
            "white_before": judged.before[name].white,
            "white_after": judged.after[name].white,
        }
    return table


def findings(found: Found, split: Split) -> list[dict[str, Any]]:
    """The findings as diagnosis.json has them."""
    listed = []
    previous = found.baseline
    for one in found.findings:
        stage = next(stage for stage in found.stages if stage.taken is one)
        near = inseparable(stage)
        values = one.values
        if one.law is None:
            values = CAUSES[one.cause].parameters_of(found.final)
        origin = found.final.world.measured.origin_s
        listed.append(
            {
                "cause": one.cause,
                "confidence": confidence(stage) / (1 + len(near)),
                "parameters": {
                    name: {"value": value + (origin if name == "onset_s" else 0.0), "std": std}
                    for name, (value, std) in values.items()
                },
                "held_out": _held_out(one, previous, split),
                "indistinguishable_from": near,
                "experiment": experiment(one.cause, near, found.final.world) if near else None,
                "note": one.note or None,
            }
        )
        if one.law is None:
            previous = one.fit
    return listed


def _held_out(one: Candidate, previous: Fit, split: Split) -> dict[str, float]:
    """Errors on the held-out part before and after this finding, in the channel that it mends most."""
    best = (0.0, 1.0, 1.0)
    first, last = make_data(previous.world, split), make_data(one.fit.world, split)
    for name in previous.world.channels:
        before, spread, _ = _error(previous, first, name)
        after, _, _ = _error(one.fit, last, name)
        if before > 0.0 and 1.0 - after / before > best[0]:
            best = (1.0 - after / before, before / spread, after / spread)
    reduction, before, after = best
    return {
        "nrmse_before": before,
        "nrmse_after": after,
        "reduction": reduction,
        "log_score_gain": one.held_gain,
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
