"""Which column tells the time, in which unit, at which rate, with which gaps.

Time grows from row to row. Its unit shows in its size: 1.4e9 s, 1.4e12 ms, 1.4e18 ns are the same instant of our days;
a clock that starts anywhere has steps that make a rate of some Hz to some 10 kHz in one unit only.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stillarm.tables.table import Table, Values, as_floats

_EPOCH = {"s": (0.9e9, 2.5e9), "ms": (0.9e12, 2.5e12), "us": (0.9e15, 2.5e15), "ns": (0.9e18, 2.5e18)}
_BY_STEP = (("s", 1e-5, 0.21), ("ms", 0.21, 50.0), ("us", 50.0, 1e5), ("ns", 1e5, 1e9))
SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}
GAP = 1.5  # times the usual step
_FIRST = ("time_s", "received_s")  # the contract's own clocks


@dataclass(frozen=True)
class Clock:
    """A column that tells the time. why: how its unit was found. zero: to be taken off, in its unit."""

    column: str
    unit: str
    why: str
    zero: float | int


@dataclass(frozen=True)
class Sampling:
    """rate_hz: of the usual step; None: unknown. gaps, repeats, backward: counts. jitter_s: std of the other steps."""

    rate_hz: float | None
    jitter_s: float
    gaps: int
    longest_gap_s: float
    repeats: int
    backward: int


def grows(values: Values) -> bool:
    """Whether a column may be a time: it grows in nearly all rows, and its growth is much alike."""
    floats = as_floats(values)
    steps = np.diff(floats[np.isfinite(floats)])
    if len(steps) < 3 or len(steps) < 0.9 * (len(floats) - 1):
        return False
    forward = steps[steps > 0.0]
    if len(forward) < 0.5 * len(steps) or np.mean(steps < 0.0) > 0.002:
        return False
    usual = float(np.median(forward))
    return float(np.mean((forward > 0.2 * usual) & (forward < 5.0 * usual))) > 0.9


def is_ramp(values: Values) -> bool:
    """Whether a column is a clock by its values, not its name: equal steps throughout, to a hundredth, and not of 1."""
    floats = as_floats(values)
    if len(floats) < 8 or not np.isfinite(floats).all():
        return False
    steps = np.diff(floats)
    usual = float(np.median(steps))
    return usual > 0.0 and usual != 1.0 and float(np.max(np.abs(steps - usual))) < 0.01 * usual


def unit_of(values: Values, stated: str) -> tuple[str, str]:
    """A time's unit and how it was found. stated: s, ms, us, ns, min, or empty."""
    floats = as_floats(values)
    floats = floats[np.isfinite(floats)]
    usual = _usual_step(floats)
    for unit, (low, high) in _EPOCH.items():
        if low < floats[0] < high and usual > 0.0 and 0.1 < 1.0 / (usual * SECONDS[unit]) < 1e6:
            return unit, "since 1970"
    if stated:
        return stated, "stated"
    return next(
        ((unit, "by its step") for unit, low, high in _BY_STEP if low <= usual < high), ("s", "assumed")
    )


def _usual_step(floats: Values) -> float:
    steps = np.diff(floats)
    forward = steps[steps > 0.0]
    return float(np.median(forward)) if len(forward) else 0.0


def best_clock(table: Table, candidates: dict[str, str]) -> Clock | None:
    """The column to take as time. candidates: names that may be, each with its stated unit or "".

    The one with the fewest repeated values, then the smoothest: a stamp in ns before one in whole ms.
    """
    found = []
    for order, (name, stated) in enumerate(candidates.items()):
        values = table.columns[name]
        if not grows(values):
            continue
        floats = as_floats(values)
        steps = np.diff(floats[np.isfinite(floats)])
        usual = _usual_step(floats[np.isfinite(floats)])
        unit, why = unit_of(values, stated)
        counts = bool(usual == 1.0 and np.all(steps == np.round(steps)) and not stated)
        found.append(
            (
                (
                    name not in _FIRST,
                    counts,
                    round(float(np.mean(steps <= 0.0)), 3),
                    round(float(np.std(steps) / usual), 2),
                    order,
                ),
                name,
                unit,
                why,
            )
        )
    if not found:
        return None
    _, name, unit, why = min(found)
    unit, why = _beside(table, name, unit, why, found)
    values = table.columns[name]
    first = values[np.isfinite(as_floats(values))][0]
    far = abs(float(first)) * SECONDS[unit] > 1e8
    zero: float | int = (int(first) if values.dtype.kind == "i" else float(first)) if far else 0
    return Clock(name, unit, why, zero)


def _beside(
    table: Table, name: str, unit: str, why: str, found: Sequence[tuple[object, str, str, str]]
) -> tuple[str, str]:
    """The unit by a second clock of sure unit: both pass the same time, so their slopes give the ratio of units."""
    if why in ("stated", "since 1970"):
        return unit, why
    for _, other, other_unit, other_why in found:
        if other == name or other_why not in ("stated", "since 1970"):
            continue
        mine, theirs = (as_floats(table.columns[c])[[0, -1]] for c in (name, other))
        second = (theirs[1] - theirs[0]) * SECONDS[other_unit] / (mine[1] - mine[0])
        for candidate, size in SECONDS.items():
            if 0.98 < second / size < 1.02:
                return candidate, f"as {other} passes"
    return unit, why


def sampling(times_s: Values) -> Sampling:
    """Rate and gaps of a time in seconds."""
    steps = np.diff(times_s[np.isfinite(times_s)])
    forward = steps[steps > 0.0]
    if not len(forward):
        return Sampling(None, np.nan, 0, 0.0, int(np.sum(steps == 0.0)), int(np.sum(steps < 0.0)))
    usual = float(np.median(forward))
    regular = forward[forward < GAP * usual]
    mean = float(np.mean(regular)) if len(regular) else usual
    gaps = forward[forward >= GAP * usual]
    return Sampling(
        rate_hz=1.0 / mean,
        jitter_s=float(np.std(regular)) if len(regular) else 0.0,
        gaps=len(gaps),
        longest_gap_s=float(gaps.max()) if len(gaps) else 0.0,
        repeats=int(np.sum(steps == 0.0)),
        backward=int(np.sum(steps < 0.0)),
    )


def rows_per_tick(values: Values) -> float | None:
    """Rows for each value of a clock that shows whole seconds only: the rate, if nothing else tells it. None: no such.

    The median of complete runs of one value; the first and the last run are cut.
    """
    floats = as_floats(values)
    if not np.all(np.isfinite(floats)) or np.any(floats != np.round(floats)):
        return None
    changes = np.flatnonzero(np.diff(floats) != 0.0)
    if len(changes) < 4 or np.mean(np.diff(floats)[changes] == 1.0) < 0.7:
        return None
    runs = np.diff(changes)
    middle = float(np.median(runs))
    close = runs[np.abs(runs - middle) < 0.2 * middle]
    return float(np.mean(close)) if middle >= 5.0 and len(close) >= 0.7 * len(runs) else None
