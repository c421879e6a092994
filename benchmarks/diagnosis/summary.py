"""Summarises the marked trials in the figures of the contract, with Wilson intervals."""

from itertools import pairwise
from math import inf, sqrt
from statistics import median
from typing import Any

from stillarm.benchmarks.diagnosis.mark import median_of

ORACLE_NATS = 12.0
"""Log-likelihood ratio from which an oracle that knows the cause is sure that it is there: 160 000 to 1."""
_BINS = (0.0, 0.15, 1.3, 3.0, 10.0, 30.0, inf)  # sizes in units of the noise
_LEAST_TRIALS = 3  # for a size from which 80 % are named
Rows = list[dict[str, Any]]


def summary(rows: Rows, trials: int, seed: int) -> dict[str, Any]:
    """The content of the benchmark's result file."""
    one, none, unknown, two = (
        [r for r in rows if r["kind"] == kind] for kind in ("one", "none", "unknown", "two")
    )
    rates = {
        "naming_rate": [r["right"] for r in one],
        "false_alarm_rate": [r["false_alarm"] for r in none],
        "unexplained_rate": [r["right"] for r in unknown],
        "misnamed_rate": [r["misnamed"] for r in one + unknown + none],
        "two_effects_rate": [r["right"] for r in two],
    }
    return {
        "trials": trials,
        "seed": seed,
        **{name: sum(marks) / len(marks) if marks else None for name, marks in rates.items()},
        "intervals": {name: wilson(sum(marks), len(marks)) for name, marks in rates.items() if marks},
        "counts": {name: [sum(marks), len(marks)] for name, marks in rates.items()},
        "too_small": {"naming_rate": _too_small(one), "unexplained_rate": _too_small(unknown)},
        "doubtful": sum(r["doubtful"] for r in rows),
        "parameter_error_median": median_of(one, "parameter_error"),
        "gain_ratio_median": median_of(one, "gain_ratio"),
        "seconds_median": median_of(rows, "seconds"),
        "cpu_s_median": median_of(rows, "cpu_s"),
        "making_cpu_s_median": median_of(rows, "making_cpu_s"),
        "compared": {
            "parameter_error_median": sum(r["parameter_error"] is not None for r in one),
            "gain_ratio_median": sum(r["gain_ratio"] is not None for r in one),
        },
        "failed": sum(r["error"] is not None for r in rows),
        "by_size": _by_size(one),
        "oracle": _oracle(one),
        "by_cause": _by_cause(one),
        "confusion": _confusion(one + none + unknown),
        "misses": [_miss(r) for r in rows if not r["right"]],
    }


def wilson(hits: int, of: int) -> list[float]:
    """Wilson's interval of a rate, 95 %."""
    z = 1.96
    p = hits / of
    centre, spread = p + z * z / (2 * of), z * sqrt(p * (1.0 - p) / of + z * z / (4 * of * of))
    scale = 1.0 / (1.0 + z * z / of)
    return [max(scale * (centre - spread), 0.0), min(scale * (centre + spread), 1.0)]


def _too_small(rows: Rows) -> list[int]:
    """Of the trials whose effect is so small that `none` is right: [right, of]."""
    small = [r["right"] for r in rows if r["expected"] == "none"]
    return [sum(small), len(small)]


def _confusion(rows: Rows) -> dict[str, dict[str, int]]:
    """{what was hidden: {what was answered first: count}}."""
    confusion: dict[str, dict[str, int]] = {}
    for row in rows:
        counts = confusion.setdefault(row["cause"] or "none", {})
        counts[row["answer"]] = counts.get(row["answer"], 0) + 1
    return confusion


def _detected(rows: Rows) -> int:
    """How many have any verdict but `none`."""
    return sum(r["verdict"] not in (None, "none") for r in rows)


def _by_size(rows: Rows) -> list[dict[str, Any]]:
    """Detection and naming against size. oracle: of how many trials the log-likelihood ratio of an oracle reaches
    ORACLE_NATS by its lower bound, and of how many there is a bound."""
    out = []
    for low, high in pairwise(_BINS):
        here = [r for r in rows if low <= r["size_in_noise"] < high]
        if not here:
            continue
        detected, named = _detected(here), sum(r["named"] for r in here)
        nats = [r["oracle_nats"] for r in here if r["oracle_nats"] is not None]
        out.append(
            {
                "from_size": low,
                "to_size": None if high == inf else high,
                "trials": len(here),
                "detected": detected,
                "detected_interval": wilson(detected, len(here)),
                "named": named,
                "named_interval": wilson(named, len(here)),
                "oracle": [sum(one >= ORACLE_NATS for one in nats), len(nats)],
            }
        )
    return out


def _oracle(rows: Rows) -> dict[str, Any]:
    """The size in units of the noise at which the oracle's bound reaches ORACLE_NATS, median over the trials: nats grow
    with the square of the size, so a trial's own is its size times sqrt(ORACLE_NATS / nats)."""
    sizes = [r["size_in_noise"] * sqrt(ORACLE_NATS / r["oracle_nats"]) for r in rows if r["oracle_nats"]]
    return {
        "nats": ORACLE_NATS,
        "size_in_noise_median": median(sizes) if sizes else None,
        "trials": len(sizes),
    }


def _by_cause(rows: Rows) -> dict[str, dict[str, Any]]:
    """For each cause: how often it was named, and the size in units of the noise from which 80 % of at least three
    trials are named (None if there is none)."""
    out = {}
    for cause in sorted({r["cause"] for r in rows}):
        here = sorted((r for r in rows if r["cause"] == cause), key=lambda r: r["size_in_noise"])
        least = None
        for k in range(len(here) - _LEAST_TRIALS + 1):
            above = here[k:]
            if sum(r["named"] for r in above) >= 0.8 * len(above):
                least = here[k]["size_in_noise"]
                break
        out[cause] = {
            "trials": len(here),
            "detected": _detected(here),
            "named": sum(r["named"] for r in here),
            "least_size_80_percent": least,
        }
    return out


def _miss(row: dict[str, Any]) -> dict[str, Any]:
    return {
        "kind": row["kind"],
        "number": row["number"],
        "hidden": [f"{h['cause']} ({h['form']}) of {h['size_in_noise']:.2g}" for h in row["hidden"]],
        "expected": row["expected"],
        "verdict": row["verdict"],
        "answers": [a["cause"] for a in row["answers"]],
        "error": row["error"],
    }
