"""Prints a campaign's result."""

from collections.abc import Iterator
from typing import Any

_RATES = {
    "naming_rate": ("one cause hidden: named first", ">= 95 %"),
    "false_alarm_rate": ("nothing hidden: false alarm", "<= 3 %"),
    "unexplained_rate": ("unknown effect: unexplained", ">= 85 %"),
    "misnamed_rate": ("unknown effect: confidently misnamed", "<= 5 %"),
    "two_effects_rate": ("two causes hidden: both named", ">= 85 %"),
}
_MEDIANS = {
    "parameter_error_median": ("error of the size, median", "<= 5 %", 100.0, "%"),
    "gain_ratio_median": ("gain over the true model's, median", ">= 95 %", 100.0, "%"),
    "seconds_median": ("a diagnosis, median", "", 1.0, "s"),
    "cpu_s_median": ("processor time of a diagnosis, median", "", 1.0, "s"),
    "making_cpu_s_median": ("processor time to hide and size, median", "", 1.0, "s"),
}


def lines(result: dict[str, Any]) -> Iterator[str]:
    """Yield lines: rates with their intervals, medians, naming against size, and every miss with its number."""
    for key, (words, wanted) in _RATES.items():
        if result[key] is None:
            continue
        hits, of = result["counts"][key]
        low, high = result["intervals"][key]
        rate = f"{100 * result[key]:5.1f} %  ({100 * low:.1f} to {100 * high:.1f})"
        yield f"{words:<40} {rate}  {hits} of {of}, wanted {wanted}"
    for key, (words, wanted, unit, name) in _MEDIANS.items():
        value = "-" if result[key] is None else f"{unit * result[key]:.1f} {name}"
        yield f"{words:<40} {value}" + (f"  wanted {wanted}" if wanted else "")
    for row in result["by_nats"]:
        to = "and over" if row["to_nats"] is None else f"to {row['to_nats']:.0f}"
        yield f"{row['from_nats']:.0f} {to} nats: {row['named']} of {row['trials']} named, {row['detected']} detected"
    for name, row in result["by_cause"].items():
        least, noise = row["least_nats_80_percent"], row["least_over_noise_80_percent"]
        if least is not None:
            from_on = f"80 % from {least:.0f} nats ({noise:.2g} of the noise)"
        else:
            from_on = "80 % at no size" if row["trials"] > 2 else "too few trials for a size"
        yield f"{name:<34} {row['named']} of {row['trials']} named, {row['detected']} detected; {from_on}"
    for miss in result["misses"]:
        hidden = ", ".join(miss["hidden"]) or "nothing"
        answered = miss["error"] or f"{miss['verdict']} {', '.join(miss['answers'])}".strip()
        yield f"miss: --seed {result['seed']}, {miss['kind']} {miss['number']}: {hidden}; answered {answered}"
    if result["misses"]:
        yield "to look at one: python -m tests.hidden_world.write --trial KIND:NUMBER --seed SEED DIR"
