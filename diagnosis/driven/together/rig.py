"""Several recordings of one driven rig in, one result out, with what holds in each of them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

from stillarm.common.files.model import Model
from stillarm.diagnosis.driven.decision.decide import DrivenFinding, Rest, rest_of
from stillarm.diagnosis.driven.declared import with_findings
from stillarm.diagnosis.driven.diagnosed import DrivenResult, Tick, channel_row, diagnose_read, name_of
from stillarm.diagnosis.driven.fitting.fitting import DrivenFit
from stillarm.diagnosis.driven.recording.own import base_of, numbers_in, recording_of
from stillarm.diagnosis.driven.recording.signals import Driven
from stillarm.diagnosis.driven.together.joining import joined, joined_split
from stillarm.diagnosis.driven.together.proof import Proof, proofs

_NO_SIZE = ("log_", "zeta_", "ripple_cycles", "onset", "share", "late")
_NOTHING = 0.1  # of the largest recording's size: less is a cause that does not hold there
_PROOF_SHARE = 0.15  # of the time


@dataclass(frozen=True)
class RigResult:
    """rig: of all recordings together; its table has a row for each under "recordings". views: each recording's own
    table, in the same form; extended: its own model, with the causes that hold there."""

    rig: DrivenResult
    views: tuple[dict[str, Any], ...]
    extended: tuple[Model, ...]


def diagnose_rig(
    recordings: Sequence[Driven],
    labels: Sequence[str],
    model: Model | None,
    hold_out: Sequence[tuple[float, float]] = (),
    tick: Tick = lambda done, what: None,
    left_s: Callable[[], float] = lambda: inf,
) -> RigResult:
    """Diagnose recordings of one rig. labels: what each is called in the answer. Raises UserError where they cannot be
    one rig's, or where the model is none that a rig can have."""
    driven = joined(recordings)
    split = joined_split(driven, [one.origin_s for one in recordings], hold_out)
    proof_s = _PROOF_SHARE * min(left_s(), 1e9)
    result = diagnose_read(driven, split, model, "the model", tick, lambda: left_s() - proof_s)
    tick(0.95, "proof of each recording by the others")
    verdict, table = result.verdict, result.table
    untried: tuple[Proof | None, ...] = (None,) * driven.recordings
    proven = proofs(result.searched.start, verdict.final, left_s) if verdict.findings else untried
    table["findings"] = _by_cause(table["findings"], verdict.findings, verdict.final, labels)
    table["recordings"] = [_recording_row(result, label, k, proven[k]) for k, label in enumerate(labels)]
    if verdict.findings and None in proven:
        table["looked_at"]["left_out"].append("proof of each recording by the others")
    return RigResult(
        result,
        tuple(_view(table, k) for k in range(driven.recordings)),
        tuple(
            with_findings(model or Model(), verdict.findings, verdict.final.numbers, k)
            for k in range(driven.recordings)
        ),
    )


def _by_cause(
    rows: list[dict[str, Any]], findings: Sequence[DrivenFinding], final: DrivenFit, labels: Sequence[str]
) -> list[dict[str, Any]]:
    """One row for each cause: where it holds, and what it is there."""
    causes = dict.fromkeys(one.form.cause for one in findings)
    return [
        _cause_row(
            [(row, one) for row, one in zip(rows, findings, strict=True) if one.form.cause == cause],
            final,
            labels,
        )
        for cause in causes
    ]


def _cause_row(
    of_cause: list[tuple[dict[str, Any], DrivenFinding]], final: DrivenFit, labels: Sequence[str]
) -> dict[str, Any]:
    row, first = of_cause[0]
    forms = [one.form for _, one in of_cause]
    names = list(dict.fromkeys(base_of(name) for form in forms for name in form.numbers if name != "late"))
    everywhere = any(recording_of(form.numbers[0]) is None for form in forms)
    own = {recording_of(form.numbers[0]) for form in forms}
    holds = [k for k in range(len(labels)) if everywhere or k in own]
    size = {k: _size(names, numbers_in(final.numbers, k)) for k in holds}
    if everywhere and not first.own:
        holds = [k for k in holds if size[k] >= _NOTHING * max(size.values())]
    by_recording = {labels[k]: _parameters(names, final, k) for k in holds}
    if not first.own:
        row = row | {"parameters": by_recording[labels[holds[0]]]}
    where = {"only_in": [labels[k] for k in holds]} if len(holds) < len(labels) else {}
    apart = {"by_recording": by_recording} if own != {None} and len(holds) > 1 else {}
    return row | where | apart | {"holds_in": [labels[k] for k in holds]}


def _size(names: Sequence[str], numbers: dict[str, float]) -> float:
    return max((abs(numbers.get(one, 0.0)) for one in names if not one.startswith(_NO_SIZE)), default=1.0)


def _parameters(names: Sequence[str], final: DrivenFit, recording: int) -> dict[str, Any]:
    numbers, std = numbers_in(final.numbers, recording), numbers_in(final.std, recording)
    return {
        one.replace(" ", "_"): {"value": float(numbers[one]), "std": float(std.get(one, 0.0))}
        for one in names
        if one in numbers
    }


def _recording_row(result: DrivenResult, label: str, k: int, proof: Proof | None) -> dict[str, Any]:
    start, final = result.searched.start.part(k), result.verdict.final.part(k)
    driven = final.box.driven
    rests = [rest_of(final, one.name) for one in driven.outputs]
    channels = {name_of(driven, one.channel): channel_row(driven, start, final, one) for one in rests}
    foretold = None
    if proof is not None:
        usual = {
            name: row["noise_floor"] / one.noise
            for (name, row), one in zip(channels.items(), rests, strict=True)
        }
        foretold = {
            name: {"nrmse_before": proof.rms[one.channel][0] * usual[name],
                   "nrmse_after": proof.rms[one.channel][1] * usual[name]}
            for name, one in zip(channels, rests, strict=True)
        }  # fmt: skip
    return {
        "recording": label,
        "channels": channels,
        "foretold_by_the_others": foretold,
        "log_score_gain": None if proof is None else proof.nats,
        "worse": None if proof is None else proof.worse,
        "unexplained": _largest(driven, rests),
    }


def _largest(driven: Driven, rests: Sequence[Rest]) -> dict[str, Any] | None:
    """What is left and matters most; None where nothing does."""
    matters = [one for one in rests if one.matters]
    if not matters:
        return None
    worst = max(matters, key=lambda one: one.rms / one.noise)
    return {
        "channel": name_of(driven, worst.channel),
        "band_hz": list(worst.band_hz),
        "dependence": "see the curves of the missing force in the rig's report",
        "term": "",
    }


def _view(table: dict[str, Any], k: int) -> dict[str, Any]:
    """The table as one recording sees it."""
    row = table["recordings"][k]
    label = row["recording"]
    findings = [
        one | {"parameters": one.get("by_recording", {}).get(label, one["parameters"])}
        for one in table["findings"]
        if label in one["holds_in"]
    ]
    left = row["unexplained"]
    verdict = table["verdict"] if findings else "unexplained" if left else "none"
    unexplained = (left or table["unexplained"]) if verdict == "unexplained" else None
    own = {"verdict": verdict, "channels": row["channels"], "findings": findings, "unexplained": unexplained}
    return table | own | {"recordings": [row], "rig": "../diagnosis.json"}
