"""Marks one trial: compares the answer with what was hidden.

right        kind one: the cause is the first finding, or the first finding names it as the one other cause that it
             cannot be distinguished from, and the contract lists the pair as hard or impossible to distinguish
             kind two: both are among the findings, each in that sense
             kind none: verdict `none` and no finding; kind unknown: verdict `unexplained` and no finding at 0.5 or over
misnamed     a finding at a confidence of 0.5 or over that was not hidden: the first (one, unknown) or any (two)
"""

from statistics import median
from typing import Any

CONFIDENT = 0.5  # confidence from which a finding counts

INSEPARABLE = {
    frozenset(pair)
    for pair in (
        ("joint_friction", "drive_deadband"),
        ("accelerometer_lag", "drive_dead_time"),
        ("camera_clock_skew", "delay_drift"),
        ("stale_frame_buffer", "clock_step"),
    )
}
"""Pairs of causes that may form a class of two. The contract also pairs causes with other effects (participation, sag,
a step of the delay); those need no entry. A step of received_s is a step of the delay."""

_GAIN_CHANNELS = {
    "acceleration_m_s2": ("accel",),
    "joint_position_rad": ("position",),
    "joint_velocity_rad_s": ("velocity",),
    "displacement_px": ("displacement", "image"),
}


def mark(truth: dict[str, Any], asked: dict[str, Any]) -> dict[str, Any]:
    """The trial as one row of plain values: truth, answer and marks."""
    answer = asked["answer"]
    row: dict[str, Any] = {
        "kind": truth["kind"],
        "seed": truth["seed"],
        "number": truth["number"],
        "hidden": truth["hidden"],
        "duration_s": truth["duration_s"],
        "over_noise": truth["over_noise"],
        "seconds": asked["seconds"],
        "cpu_s": asked.get("cpu_s"),
        "error": asked["error"],
        "verdict": None,
        "answers": [],
        "right": False,
        "misnamed": False,
        "answer": "failed",
        "parameter_error": None,
        "value_errors": {},
        "gain_ratio": None,
    }
    if answer is None:
        return row
    findings = answer["findings"]
    names = [hidden["cause"] for hidden in truth["hidden"]]
    row["verdict"] = answer["verdict"]
    row["answers"] = [
        {key: finding.get(key) for key in ("cause", "confidence", "indistinguishable_from", "parameters")}
        for finding in findings
    ]
    open_question = truth["kind"] == "unknown" and not any(_sure(f) for f in findings)
    row["answer"] = findings[0]["cause"] if findings and not open_question else answer["verdict"]
    row["right"] = _right(truth["kind"], names, answer)
    row["misnamed"] = _misnamed(truth["kind"], names, findings)
    if truth["kind"] == "one" and row["right"]:
        row |= _measured(truth, answer)
    return row


def covers(finding: dict[str, Any], cause: str) -> bool:
    """Whether a finding names a cause, or an allowed class of two that contains it."""
    if finding["cause"] == cause:
        return True
    others = finding.get("indistinguishable_from") or []
    return others == [cause] and frozenset((finding["cause"], cause)) in INSEPARABLE


def _right(kind: str, names: list[str], answer: dict[str, Any]) -> bool:
    findings = answer["findings"]
    if kind == "none":
        return answer["verdict"] == "none" and not findings
    if kind == "unknown":
        return answer["verdict"] == "unexplained" and not any(_sure(f) for f in findings)
    if kind == "one":
        return bool(findings) and covers(findings[0], names[0])
    return all(any(covers(finding, name) for finding in findings) for name in names)


def _misnamed(kind: str, names: list[str], findings: list[dict[str, Any]]) -> bool:
    judged = findings if kind == "two" else findings[:1]
    return any(_sure(f) and not any(covers(f, name) for name in names) for f in judged)


def _sure(finding: dict[str, Any]) -> bool:
    return float(finding.get("confidence", 1.0)) >= CONFIDENT


def _measured(truth: dict[str, Any], answer: dict[str, Any]) -> dict[str, Any]:
    """Errors of the parameters and of the gain, if the cause itself was named."""
    hidden, finding = truth["hidden"][0], answer["findings"][0]
    if finding["cause"] != hidden["cause"]:
        return {}
    errors = {}
    for name, true in hidden["parameters"].items():
        told = finding["parameters"].get(name)
        if told is not None and name != "onset_s" and true:
            errors[name] = abs(float(told["value"]) - true) / abs(true)
    size = hidden["size"]
    error = None
    if size in errors:
        error = errors[size] * abs(hidden["parameters"][size]) / abs(hidden["departure"])
    return {"value_errors": errors, "parameter_error": error, "gain_ratio": _gain_ratio(truth, answer)}


def _gain_ratio(truth: dict[str, Any], answer: dict[str, Any]) -> float | None:
    """Fraction of the true model's variance reduction that was reached, in the channel that shows the cause most."""
    column = truth["strongest"]
    if column not in _GAIN_CHANNELS or truth["hidden"][0]["law"]:
        return None
    for name, channel in answer["channels"].items():
        if name == column or any(word in name for word in _GAIN_CHANNELS[column]):
            before, after = channel.get("nrmse_before"), channel.get("nrmse_after")
            floor = truth["floor"].get(column)
            if before is None or after is None or floor is None or before <= floor:
                return None
            return float((before**2 - after**2) / (before**2 - floor**2))
    return None


def median_of(rows: list[dict[str, Any]], key: str) -> float | None:
    """Median over the rows that contain the value."""
    values = [row[key] for row in rows if row.get(key) is not None]
    return float(median(values)) if values else None
