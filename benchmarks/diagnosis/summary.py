"""Summarises the marked trials in the figures of the contract, with Wilson intervals."""

from itertools import pairwise
from math import sqrt
from typing import Any

from stillarm.benchmarks.diagnosis.mark import median_of

_BINS = (50.0, 100.0, 200.0, 400.0, 800.0, float("inf"))  # sizes, nats
_LEAST_TRIALS = 3  # for a size from which 80 % are named
Rows = list[dict[str, Any]]


def summary(rows: Rows, trials: int, seed: int) -> dict[str, Any]:
    """The content of the benchmark's result file."""
    one, none, unknown, two = (
        [r for r in rows if r["kind"] == kind] for kind in ("one", "none", "unknown", "two")
    )
    rates = {
        "naming_rate": ([r["right"] for r in one]),
        "false_alarm_rate": ([not r["right"] for r in none]),
        "unexplained_rate": ([r["right"] for r in unknown]),
        "misnamed_rate": ([r["misnamed"] for r in unknown]),
        "two_effects_rate": ([r["right"] for r in two]),
    }
    confusion: dict[str, dict[str, int]] = {}
    for row in one + none + unknown:
        name = row["hidden"][0]["cause"] if row["hidden"] else "none"
        counts = confusion.setdefault(name, {})
        counts[row["answer"]] = counts.get(row["answer"], 0) + 1
    return {
        "trials": trials,
        "seed": seed,
        **{name: sum(marks) / len(marks) if marks else None for name, marks in rates.items()},
        "intervals": {name: wilson(sum(marks), len(marks)) for name, marks in rates.items() if marks},
        "counts": {name: [sum(marks), len(marks)] for name, marks in rates.items()},
        "parameter_error_median": median_of(one, "parameter_error"),
        "parameter_value_error_median": _values(one),
        "gain_ratio_median": median_of(one, "gain_ratio"),
        "seconds_median": median_of(rows, "seconds"),
        "cpu_s_median": median_of(rows, "cpu_s"),
        "making_cpu_s_median": median_of(rows, "making_cpu_s"),
        "failed": sum(r["error"] is not None for r in rows),
        "by_nats": _by_nats(one),
        "by_cause": _by_cause(one),
        "confusion": confusion,
        "misses": [_miss(r) for r in rows if not r["right"]],
    }


def wilson(hits: int, of: int) -> list[float]:
    """Wilson's interval of a rate, 95 %."""
    z = 1.96
    p = hits / of
    centre, spread = p + z * z / (2 * of), z * sqrt(p * (1.0 - p) / of + z * z / (4 * of * of))
    scale = 1.0 / (1.0 + z * z / of)
    return [max(scale * (centre - spread), 0.0), min(scale * (centre + spread), 1.0)]


def _values(rows: Rows) -> float | None:
    values = sorted(error for r in rows for error in r["value_errors"].values())
    return float(values[len(values) // 2]) if values else None


def _by_nats(rows: Rows) -> list[dict[str, Any]]:
    """Detection (any verdict but `none`) and naming against size."""
    out = []
    for low, high in pairwise(_BINS):
        here = [r for r in rows if low <= r["hidden"][0]["nats"] < high]
        if here:
            detected = sum(r["verdict"] not in (None, "none") for r in here)
            named = sum(r["right"] for r in here)
            out.append(
                {
                    "from_nats": low,
                    "to_nats": None if high == float("inf") else high,
                    "trials": len(here),
                    "detected": detected,
                    "detected_interval": wilson(detected, len(here)),
                    "named": named,
                    "named_interval": wilson(named, len(here)),
                }
            )
    return out


def _by_cause(rows: Rows) -> dict[str, dict[str, Any]]:
    """For each cause: how often it was named, and the size from which 80 % of at least three trials are named (None if
    there is none), in nats and as rms over the noise rms in the channel that shows it most."""
    out = {}
    for cause in sorted({r["hidden"][0]["cause"] for r in rows}):
        here = sorted(
            (r for r in rows if r["hidden"][0]["cause"] == cause), key=lambda r: r["hidden"][0]["nats"]
        )
        least = None
        for k in range(len(here) - _LEAST_TRIALS + 1):
            above = here[k:]
            if sum(r["right"] for r in above) >= 0.8 * len(above):
                least = here[k]
                break
        out[cause] = {
            "trials": len(here),
            "detected": sum(r["verdict"] not in (None, "none") for r in here),
            "named": sum(r["right"] for r in here),
            "least_nats_80_percent": None if least is None else least["hidden"][0]["nats"],
            "least_over_noise_80_percent": None if least is None else least["over_noise"],
        }
    return out


def _miss(row: dict[str, Any]) -> dict[str, Any]:
    return {
        "kind": row["kind"],
        "number": row["number"],
        "hidden": [f"{h['cause']} at {h['nats']:.0f} nats" for h in row["hidden"]],
        "verdict": row["verdict"],
        "answers": [a["cause"] for a in row["answers"]],
        "error": row["error"],
    }
