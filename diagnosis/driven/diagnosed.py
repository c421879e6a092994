"""A driven rig's recording in, what diagnosis.json holds out. docs/measured-rigs.md tells how it decides."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import exp, inf, pi
from typing import Any

import numpy as np

from stillarm.common.files.model import Model
from stillarm.common.recording.reader import Recording
from stillarm.diagnosis.data.split import Split, stated
from stillarm.diagnosis.driven.decision.decide import DrivenFinding, Rest, Verdict, decide
from stillarm.diagnosis.driven.declared import declared_numbers, with_findings
from stillarm.diagnosis.driven.fitting.fitting import DrivenFit
from stillarm.diagnosis.driven.greybox.laws import carried_by
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven, read_driven
from stillarm.diagnosis.driven.search.judging import gains
from stillarm.diagnosis.driven.search.search import Searched, search
from stillarm.diagnosis.driven.search.slow import with_slow_torques
from stillarm.diagnosis.driven.starts.stated import stated_by

Tick = Callable[[float, str], None]
_CHANNELS = {"position": "joint_position", "motor": "motor_position", "velocity": "joint_velocity"}
_SEARCH_SHARE = 0.75  # of the time that there is; the rest is for the verdict


@dataclass(frozen=True)
class DrivenResult:
    """`table` is what diagnosis.json holds; the rest is for the report. extended: the model as given, or none known,
    with the causes that were found."""

    table: dict[str, Any]
    driven: Driven
    searched: Searched
    verdict: Verdict
    extended: Model


def diagnose_driven(
    recording: Recording,
    model: Model | None,
    hold_out: Sequence[tuple[float, float]],
    tick: Tick,
    left_s: Callable[[], float] = lambda: inf,
) -> DrivenResult:
    """Diagnose a recording of a joint that a torque, a current or a voltage drives. Raises UserError where it holds too
    little. model: None where nobody knows one. left_s: how much time there is."""
    driven = read_driven(recording)
    split = stated(hold_out, driven.origin_s, driven.duration_s) if hold_out else irregular(driven.duration_s)
    return diagnose_read(driven, split, model, f"{recording.path} (its model)", tick, left_s)


def diagnose_read(
    driven: Driven,
    split: Split,
    model: Model | None,
    model_name: str,
    tick: Tick,
    left_s: Callable[[], float],
) -> DrivenResult:
    """Diagnose what was read: one recording, or several of one rig that were joined. Raises UserError for a model that
    no rig can have."""
    known = stated_by(model, driven, model_name) if model is not None else None
    causes = declared_numbers(model, driven) if model is not None else {}
    whole_s = left_s()

    def left_for_search() -> float:
        return left_s() - (1.0 - _SEARCH_SHARE) * min(whole_s, 1e9)

    searched = search(driven, split, tick, left_for_search, known, causes)
    searched = with_slow_torques(searched, left_for_search)
    tick(0.9, "verdict")
    verdict = decide(searched, left_s)
    return DrivenResult(
        table_of(driven, split, searched, verdict, known is not None),
        driven,
        searched,
        verdict,
        with_findings(model or Model(), verdict.findings, verdict.final.numbers),
    )


def table_of(
    driven: Driven, split: Split, searched: Searched, verdict: Verdict, has_model: bool
) -> dict[str, Any]:
    """The contract's table."""
    left = [
        _left_row(one) for one in sorted(verdict.rests, key=lambda one: -one.rms / one.noise) if one.rms > 0.0
    ]
    return {
        "verdict": verdict.verdict,
        "channels": {
            name_of(driven, rest.channel): channel_row(driven, searched.start, verdict.final, rest)
            for rest in verdict.rests
        },
        "findings": [_finding_row(driven, one, verdict.final) for one in verdict.findings],
        "unexplained": _unexplained(driven, verdict),
        "left": left,
        "events": [],
        "looked_at": {"left_out": list(searched.left_out)},
        "channels_left_out": driven.left_out,
        "baseline_changes": {},
        "start": {
            "from": "the model file" if has_model else "the recording alone",
            "driven_by": driven.drive,
            "numbers": start_numbers(verdict.final),
            "structure": [one.taken.form.words for one in searched.rounds if not one.taken.form.cause],
        },
        "extended_model": "extended.toml",
    }


def start_numbers(fitted: DrivenFit) -> dict[str, dict[str, float]]:
    """The linear part as fitted: gain, damping, and each mode's clamped-free frequency, damping ratio and inertia."""
    numbers, std = fitted.numbers, fitted.std
    found = {
        "gain_rad_s2_per_unit": (numbers["gain"], std.get("gain", 0.0)),
        "damping_per_s": (numbers["damping"], std.get("damping", 0.0)),
        "input_delay_s": (numbers.get("delay", 0.0), std.get("delay", 0.0)),
    }
    for i in range(1, fitted.box.modes + 1):
        hz = exp(numbers[f"log_w_{i}"]) / (2.0 * pi)
        found[f"mode_{i}_clamped_frequency_hz"] = (hz, hz * std.get(f"log_w_{i}", 0.0))
        found[f"mode_{i}_damping_ratio"] = (numbers[f"zeta_{i}"], std.get(f"zeta_{i}", 0.0))
        found[f"mode_{i}_inertia_over_hub"] = (carried_by(numbers, i), std.get(f"carries_{i}", 0.0))
    return {name: {"value": float(value), "std": float(spread)} for name, (value, spread) in found.items()}


def name_of(driven: Driven, output: str) -> str:
    """A channel's name in diagnosis.json."""
    kind = next(one.kind for one in driven.outputs if one.name == output)
    return _CHANNELS.get(kind, output.removesuffix("_m_s2").removesuffix("_m"))


def channel_row(driven: Driven, start: DrivenFit, final: DrivenFit, rest: Rest) -> dict[str, Any]:
    """A channel's row in the contract's table."""
    values = next(one.values for one in driven.outputs if one.name == rest.channel)
    usual = float(np.nanstd(values))
    return {
        "samples": int(np.isfinite(values).sum()),
        "nrmse_before": start.rms(rest.channel, True) / usual,
        "nrmse_after": final.rms(rest.channel, True) / usual,
        "noise_floor": rest.noise / usual,
        "white_before": False,
        "white_after": not rest.matters,
    }


def _finding_row(driven: Driven, one: DrivenFinding, final: DrivenFit) -> dict[str, Any]:
    without = one.without
    usual = next(float(np.nanstd(each.values)) for each in driven.outputs if each.name == one.channel)
    return {
        "cause": one.form.cause,
        "form": one.form.words,
        "begins_s": None,
        "confidence": one.confidence,
        "parameters": {
            name.replace(" ", "_"): {
                "value": float(final.numbers[name]),
                "std": float(final.std.get(name, 0.0)),
            }
            for name in one.form.numbers
            if name in final.numbers and name != "late"
        }
        | {name: {"value": value, "std": 0.0} for name, value in one.own.items()},
        "held_out": {
            "nrmse_before": without.rms(one.channel, True) / usual,
            "nrmse_after": final.rms(one.channel, True) / usual,
            "reduction": one.reduction,
            "log_score_gain": gains(one.form, final, without)[1],
        },
        "indistinguishable_from": list(one.near),
        "experiment": _EXPERIMENT if one.near else None,
        "note": None,
    }


def _left_row(one: Rest) -> dict[str, Any]:
    return {
        "channel": one.channel,
        "band_hz": list(one.band_hz),
        "rms": one.rms,
        "share_of_noise": one.rms / one.noise,
        "immaterial": not one.matters,
    }


def _unexplained(driven: Driven, verdict: Verdict) -> dict[str, Any] | None:
    if verdict.verdict != "unexplained":
        return None
    rest = max(verdict.rests, key=lambda one: one.rms / one.noise)
    return {
        "channel": name_of(driven, rest.channel),
        "band_hz": list(rest.band_hz),
        "dependence": "see the curves of the missing force",
        "term": "",
    }


_EXPERIMENT = (
    "move the joint to and fro at several constant speeds, slow ones too, and let it rest in several places"
)
