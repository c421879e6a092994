"""Marks one trial by the contract: compares the answer with what was hidden.

right        the verdict that was expected; and where a cause is to be named
             kinds one, unknown: as the first finding, or in its class of at most two; a cause that is the same law in
             this recording, or that is hidden as well and about as large, will do
             kind two: every effect that matters alone among the findings, each in that sense
named        kind one: verdict `named`, with the cause in that sense, whatever was expected
misnamed     kinds one, unknown, none: verdict `named` with a first finding that was not hidden
false alarm  kind none: a verdict that is not `none`; no answer counts as one
"""

from collections.abc import Iterable
from statistics import mean, median
from typing import Any

_MOST_TOGETHER = 2  # causes in a class that still names one
_TOLD = ("cause", "confidence", "indistinguishable_from", "parameters")
_OF_TRUTH = (
    "kind",
    "seed",
    "number",
    "duration_s",
    "expected",
    "cause",
    "also",
    "doubtful",
    "size_in_noise",
    "oracle_nats",
    "hidden",
)


def mark(truth: dict[str, Any], asked: dict[str, Any]) -> dict[str, Any]:
    """The trial as one row of plain values: truth, answer and marks."""
    answer = asked["answer"]
    row: dict[str, Any] = {
        **{key: truth[key] for key in _OF_TRUTH},
        "seconds": asked["seconds"],
        "cpu_s": asked.get("cpu_s"),
        "error": asked["error"],
        "verdict": None,
        "answers": [],
        "answer": "failed",
        "right": False,
        "named": False,
        "misnamed": False,
        "false_alarm": truth["kind"] == "none",
        "parameter_error": None,
        "value_errors": {},
        "gain_ratio": None,
    }
    if answer is None:
        return row
    findings, verdict = answer["findings"], answer["verdict"]
    names = verdict == "named" and bool(findings)
    row["verdict"] = verdict
    row["answers"] = [{key: finding.get(key) for key in _TOLD} for finding in findings]
    row["answer"] = findings[0]["cause"] if names else verdict
    row["right"] = _right(truth, answer)
    hidden = {truth["cause"], *truth["also"]}
    row["named"] = truth["kind"] == "one" and names and covers(findings[0], hidden)
    row["misnamed"] = truth["kind"] != "two" and names and not covers(findings[0], hidden)
    row["false_alarm"] = truth["kind"] == "none" and verdict != "none"
    if row["named"]:
        errors = _value_errors(truth["hidden"][0], findings[0])
        row["value_errors"] = errors
        row["parameter_error"] = mean(errors.values()) if errors else None
        row["gain_ratio"] = _gain_ratio(truth, answer)
    return row


def covers(finding: dict[str, Any], causes: Iterable[str | None]) -> bool:
    """Whether a finding names one of some causes, itself or by its class of at most two."""
    told = {finding["cause"], *(finding.get("indistinguishable_from") or [])}
    return len(told) <= _MOST_TOGETHER and bool(told & (set(causes) - {None}))


def _right(truth: dict[str, Any], answer: dict[str, Any]) -> bool:
    findings = answer["findings"]
    if answer["verdict"] != truth["expected"]:
        return False
    if truth["expected"] != "named":
        return True
    wanted = [{one["cause"], *one["same"]} for one in truth["hidden"] if one["matters"]]
    if truth["kind"] != "two" or not wanted:
        return bool(findings) and covers(findings[0], {truth["cause"], *truth["also"]})
    return all(any(covers(finding, causes) for finding in findings) for causes in wanted)


def _value_errors(hidden: dict[str, Any], finding: dict[str, Any]) -> dict[str, float]:
    """|told - true| / |true| of each parameter that both have, but an onset, whose zero is arbitrary; none where
    another cause of its class stands first, or the form's parameters are not the formula's."""
    if finding["cause"] != hidden["cause"] or not hidden["comparable"]:
        return {}
    told = finding["parameters"]
    return {
        name: abs(float(told[name]["value"]) - true) / abs(true)
        for name, true in hidden["parameters"].items()
        if name in told and name != "onset_s" and true
    }


def _gain_ratio(truth: dict[str, Any], answer: dict[str, Any]) -> float | None:
    """Share of the true model's reduction of the held-out variance that was reached, in the channel that the effect
    changes most; None where that is one of timing, or only a part of the recording was looked at."""
    name = truth["strongest"]
    channel, least = answer["channels"].get(name), truth["floor"].get(name)
    cut = any(str(one).startswith("time after") for one in answer.get("looked_at", {}).get("left_out", ()))
    if channel is None or least is None or cut:
        return None
    before, after = channel["nrmse_before"], channel["nrmse_after"]
    return float((before**2 - after**2) / (before**2 - least**2)) if before > least else None


def median_of(rows: list[dict[str, Any]], key: str) -> float | None:
    """Median over the rows that contain the value."""
    values = [row[key] for row in rows if row.get(key) is not None]
    return float(median(values)) if values else None
