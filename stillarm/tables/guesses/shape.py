"""What a column's values show by themselves: constant, flag, counter, quantised, or just numbers."""

from dataclasses import dataclass
from math import pi

import numpy as np

from stillarm.tables.table import Values, as_floats

_LEVELS = 4  # fewer distinct values are states, not a measurement
_STATES = 5  # whole values, up to as many in a long column: states or bits
_FINEST_LEVELS = 200_000  # beyond these distinct values the smallest difference is rounding
_SMOOTH = (2, 3, 5)


@dataclass(frozen=True)
class Shape:
    """kind: constant, flag (a few whole values), counter (whole, one more each row), or numbers.

    step: quantisation of the values, in their own unit; None where there is none.
    absent: share of rows without a value.
    """

    kind: str
    step: float | None
    absent: float
    low: float
    high: float
    mean: float
    std: float


def shape_of(values: Values) -> Shape:
    """The shape of one column. A column without any value is constant, with NaN for its figures."""
    floats = as_floats(values)
    there = floats[np.isfinite(floats)]
    absent = 1.0 - len(there) / max(1, len(floats))
    if not len(there):
        return Shape("constant", None, absent, np.nan, np.nan, np.nan, np.nan)
    levels = np.unique(there)
    figures = (absent, float(there.min()), float(there.max()), float(there.mean()), float(there.std()))
    if len(levels) == 1 or float(np.ptp(there)) <= 1e-12 * float(np.max(np.abs(there))):
        return Shape("constant", None, *figures)
    whole = bool(np.all(levels == np.round(levels)))
    few = len(levels) <= _STATES and len(there) > _STATES**2 and float(np.max(np.abs(levels))) < 256.0
    if whole and (few or (len(levels) == 2 and set(levels.tolist()) <= {0.0, 1.0, -1.0})):
        return Shape("flag", None, *figures)
    if whole and _counts(there):
        return Shape("counter", 1.0, *figures)
    return Shape("numbers", quantisation(levels), *figures)


def _counts(values: Values) -> bool:
    """Whether whole values grow by one in most rows, and never fall but to wrap."""
    steps = np.diff(values)
    return len(steps) > 2 and float(np.mean(steps == 1.0)) > 0.9 and float(np.mean(steps < 0.0)) < 0.01


def quantisation(levels: Values) -> float | None:
    """The step that all differences of the sorted distinct values are multiples of; None where there is none.

    The step is the smallest difference, refined over the whole range: (last - first) / round((last - first) / step).
    """
    if not _LEVELS <= len(levels) <= _FINEST_LEVELS:
        return None
    differences = np.diff(levels)
    noise = 1e-9 * float(np.max(np.abs(levels)))
    differences = differences[differences > noise]
    if not len(differences):
        return None
    step = float(differences.min())
    multiples = differences / step
    if np.max(np.abs(multiples - np.round(multiples))) > 0.02:
        return None
    if float(np.max(np.round(multiples))) <= 1.0 and len(differences) < _LEVELS:
        return None
    steps = np.round((levels - levels[0]) / step)
    return float(np.polyfit(steps, levels, 1)[0]) if len(levels) > 2 else step


def is_decimal(step: float) -> bool:
    """Whether a step is one or a few units of a decimal place: rounding of a text, not of a device."""
    for places in range(13):
        scaled = step * 10.0**places
        if abs(scaled - round(scaled)) < 1e-6 * max(1.0, scaled):
            return 0 < round(scaled) <= 10
    return False


def encoder_counts(step: float, turn: float) -> int | None:
    """Counts per turn (2 pi or 360) if a step fits an encoder: a whole number without prime factors beyond 5.

    Such numbers are rare among large ones (about 1 in 300 near 4e5), while encoders and their gears have them.
    """
    if is_decimal(step) or step <= 0.0:
        return None
    counts = turn / step
    if not 100.0 < counts < 1e9 or abs(counts - round(counts)) > max(0.01, 1e-6 * counts):
        return None
    rest = round(counts)
    for prime in _SMOOTH:
        while rest % prime == 0:
            rest //= prime
    return round(counts) if rest == 1 else None


TURNS = {"rad": 2.0 * pi, "deg": 360.0}
