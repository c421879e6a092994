"""Which columns of a table tell the time."""

import numpy as np

from stillarm.tables.guesses.names import COUNTER, FLAG, TIME, Sense
from stillarm.tables.guesses.shape import Shape
from stillarm.tables.guesses.time_column import (
    SECONDS,
    Clock,
    best_clock,
    grows,
    is_ramp,
    rows_per_tick,
    unit_of,
)
from stillarm.tables.roles import UNKNOWN
from stillarm.tables.table import Table, as_floats
from stillarm.tables.units import size_of


def clock_of(
    table: Table, senses: dict[str, Sense], shapes: dict[str, Shape]
) -> tuple[Clock | None, list[str]]:
    """A column named as time before any other; without one, a column that grows evenly and is no mere counter."""
    named = {
        n: _time_unit(s.unit, n) for n, s in senses.items() if s.quantity == TIME and s.kind != "modelled"
    }
    clock = best_clock(table, named)
    if clock is not None:
        return clock, []
    others = {
        n: ""
        for n, s in senses.items()
        if shapes[n].kind == "numbers" and (s.quantity == UNKNOWN or is_ramp(table.columns[n]))
    }
    return best_clock(table, others), []


def _time_unit(unit: str, name: str) -> str:
    """The stated unit; "seconds" as a name states it, too."""
    text = unit or name.strip().lower()
    size = size_of(text)
    if size is None or size[0] != "s":
        return ""
    return next((word for word, seconds in SECONDS.items() if np.isclose(seconds, size[1])), "")


def clocks_of(
    table: Table, senses: dict[str, Sense], shapes: dict[str, Shape], clock: Clock | None
) -> dict[str, tuple[str, str]]:
    """Every column that tells the time, with its unit and why."""
    found = {clock.column: (clock.unit, clock.why)} if clock else {}
    for name, sense in senses.items():
        if name in found or shapes[name].kind != "numbers":
            continue
        ramp = is_ramp(table.columns[name]) and sense.quantity not in (COUNTER, FLAG)
        if not (ramp or sense.quantity in (TIME, UNKNOWN)):
            continue
        if grows(table.columns[name]) and _is_line(table, name):
            found[name] = unit_of(table.columns[name], _time_unit(sense.unit, name))
    return found


def _is_line(table: Table, name: str) -> bool:
    """Whether a column is a straight line over the rows, to a hundredth: a clock, not a slow drift."""
    values = as_floats(table.columns[name])
    values = values[np.isfinite(values)]
    index = np.arange(len(values))
    rest = values - np.polyval(np.polyfit(index, values - values[0], 1), index) - values[0]
    return float(np.std(rest)) < 0.01 * float(np.std(values))


def times_s(table: Table, clock: Clock | None) -> np.ndarray | None:
    if clock is None:
        return None
    values = table.columns[clock.column]
    since = values - clock.zero if clock.zero else values
    return as_floats(since) * SECONDS[clock.unit]


def coarse_rate(table: Table, senses: dict[str, Sense]) -> tuple[float | None, list[str]]:
    for name, sense in senses.items():
        if sense.quantity == TIME and _time_unit(sense.unit, name) == "s":
            rate = rows_per_tick(table.columns[name])
            if rate is not None:
                return rate, [f"{name} shows whole seconds only; {rate:.4g} rows each, taken as the rate"]
    return None, []
