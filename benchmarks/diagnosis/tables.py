"""Prints a campaign's result."""

from collections.abc import Iterator
from typing import Any

_RATES = {
    "naming_rate": ("one cause hidden: named first", ">= 95 %"),
    "false_alarm_rate": ("nothing hidden: false alarm", "<= 2 %"),
    "unexplained_rate": ("unlisted effect: unexplained", ">= 95 %"),
    "misnamed_rate": ("named first what was not hidden", "<= 2 %"),
    "two_effects_rate": ("two causes hidden: both named", ">= 85 %"),
}
_MEDIANS = {
    "parameter_error_median": ("error of the parameters, median", "<= 3 %", 100.0, "%"),
    "gain_ratio_median": ("held-out gain over the true model's", ">= 97 %", 100.0, "%"),
    "seconds_median": ("a diagnosis, median", "", 1.0, "s"),
    "cpu_s_median": ("processor time of a diagnosis, median", "", 1.0, "s"),
    "making_cpu_s_median": ("processor time to hide and size, median", "", 1.0, "s"),
}


def lines(result: dict[str, Any]) -> Iterator[str]:
    """Yield lines: rates with their intervals, medians, naming against size, and every miss with its number."""
    yield from _rates(result)
    for key, (words, wanted, unit, name) in _MEDIANS.items():
        value = "-" if result[key] is None else f"{unit * result[key]:.1f} {name}"
        of = f"  of {result['compared'][key]} trials" if key in result["compared"] else ""
        yield f"{words:<40} {value}{of}" + (f", wanted {wanted}" if wanted else "")
    yield from _sizes(result)
    for name, row in result["by_cause"].items():
        least = row["least_size_80_percent"]
        if least is not None:
            from_on = f"80 % from {least:.2g} times the noise"
        else:
            from_on = "80 % at no size" if row["trials"] > 2 else "too few trials for a size"
        yield f"{name:<34} {row['named']} of {row['trials']} named, {row['detected']} detected; {from_on}"
    for miss in result["misses"]:
        hidden = ", ".join(miss["hidden"]) or "nothing"
        answered = miss["error"] or f"{miss['verdict']} {', '.join(miss['answers'])}".strip()
        yield (
            f"miss: --seed {result['seed']}, {miss['kind']} {miss['number']}: {hidden}; "
            f"expected {miss['expected']}; answered {answered}"
        )
    if result["misses"]:
        yield "to look at one: python -m tests.hidden_world.rigs.write OUT --trial KIND:NUMBER --seed SEED"


def _rates(result: dict[str, Any]) -> Iterator[str]:
    for key, (words, wanted) in _RATES.items():
        if result[key] is None:
            continue
        hits, of = result["counts"][key]
        low, high = result["intervals"][key]
        rate = f"{100 * result[key]:5.1f} %  ({100 * low:.1f} to {100 * high:.1f})"
        yield f"{words:<40} {rate}  {hits} of {of}, wanted {wanted}"
        right, small = result["too_small"].get(key, (0, 0))
        if small:
            yield f"  counted in that: so small that 'none' is right, and was said of {right} of {small}"
    if result["doubtful"]:
        yield f"counted in these: {result['doubtful']} near the size that matters, whatever seed was tried"


def _sizes(result: dict[str, Any]) -> Iterator[str]:
    for row in result["by_size"]:
        to = "and over" if row["to_size"] is None else f"to {row['to_size']:g}"
        sure, of = row["oracle"]
        yield (
            f"{row['from_size']:g} {to} times the noise: {row['detected']} of {row['trials']} detected, "
            f"{row['named']} named; an oracle would be sure of at least {sure} of {of}"
        )
    oracle = result["oracle"]
    if oracle["trials"]:
        yield (
            f"an oracle that knows the cause has {oracle['nats']:g} nats from {oracle['size_in_noise_median']:.2g} "
            f"times the noise on, median of {oracle['trials']} trials"
        )
