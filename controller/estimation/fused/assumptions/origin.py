"""How an assumption states its unit and its origin, so that a test can ask for both."""

from dataclasses import field
from typing import Any, TypeVar

T = TypeVar("T")

KINDS = ("paper", "derived", "bound", "measured", "chosen")
"""What an origin begins with. paper: taken from there. derived: by arithmetic, or from a rate of false alarms that is
stated. bound: what devices or physics allow. measured: on the recordings or benchmarks named. chosen: a choice."""

TRIED = (
    "chosen by trial, as far as is known on the worlds of docs/benchmark-estimators.md; no seed was recorded"
)


def assumed(value: T, unit: str, origin: str) -> T:
    """A field of a frozen dataclass. unit: what the number counts, and of what; origin: begins with one of KINDS."""
    made: Any = field(default=value, metadata={"unit": unit, "origin": origin})
    result: T = made
    return result
