"""What a table shows: its time, rate and gaps, and for each column a quantity, a unit and a role, with the reasons.

Names come first; physics names what is nameless and finds units. What neither tells stays "unknown".
"""

from dataclasses import replace

from stillarm.tables.guesses.by_physics import by_physics
from stillarm.tables.guesses.causality import causality
from stillarm.tables.guesses.column_look import ColumnLook, TableLook
from stillarm.tables.guesses.names import AGE, CONSTANT, COUNTER, FLAG, SPREAD, TIME, Sense, sense_of
from stillarm.tables.guesses.passed_units import with_units
from stillarm.tables.guesses.relations import Relations, relations_of
from stillarm.tables.guesses.role_of import assign_roles
from stillarm.tables.guesses.rotation_matrix import rotation_matrix
from stillarm.tables.guesses.shape import Shape, shape_of
from stillarm.tables.guesses.spectra import Spectra, spectra
from stillarm.tables.guesses.table_clock import clock_of, clocks_of, coarse_rate, times_s
from stillarm.tables.guesses.time_column import Sampling, sampling
from stillarm.tables.roles import INPUT, OUTPUT, UNKNOWN
from stillarm.tables.table import Table

__all__ = ["ColumnLook", "TableLook", "look"]

MOST_COMPARED = 40  # columns of one table that are compared pair by pair
_STANDING = (COUNTER, FLAG, AGE, SPREAD)  # they follow no physics of the rig


def look(table: Table) -> TableLook:
    """Guess at every column of a table."""
    shapes = {name: shape_of(values) for name, values in table.columns.items()}
    senses = {name: sense_of(name, table.units.get(name, "")) for name in table.columns}
    clock, notes = clock_of(table, senses, shapes)
    times = times_s(table, clock)
    timing = sampling(times) if times is not None else None
    rate_hz = timing.rate_hz if timing else table.rate_hz
    if clock is None and rate_hz is None:
        rate_hz, tick_notes = coarse_rate(table, senses)
        notes += tick_notes
    clocks = clocks_of(table, senses, shapes, clock)
    moving = {
        name: values
        for name, values in table.columns.items()
        if name not in clocks and shapes[name].kind == "numbers" and senses[name].quantity not in _STANDING
    }
    compared = dict(list(moving.items())[:MOST_COMPARED])
    if len(moving) > MOST_COMPARED:
        notes.append(
            f"only the first {MOST_COMPARED} of {len(moving)} moving columns are compared with each other"
        )
    held = spectra(compared)
    relations = relations_of(held, rate_hz)
    columns = [_first_look(name, shapes[name], senses[name], clocks) for name in table.columns]
    columns = by_physics(columns, relations)
    columns = rotation_matrix(columns, table)
    columns = with_units(columns, table, relations)
    columns = _pair(columns, held)
    columns = assign_roles(columns)
    if timing is None and rate_hz is not None:
        timing = Sampling(rate_hz, 0.0, 0, 0.0, 0, 0)
    return TableLook(
        table.name,
        table.rows,
        clock,
        timing,
        tuple(_told(c, relations, rate_hz) for c in columns),
        tuple(notes),
    )


def _first_look(name: str, shape: Shape, sense: Sense, clocks: dict[str, tuple[str, str]]) -> ColumnLook:
    if name in clocks:
        unit, found = clocks[name]
        return ColumnLook(
            name, shape, TIME, "", "", unit, sense.role or UNKNOWN, (f"grows evenly; unit {found}",)
        )
    if sense.quantity == UNKNOWN and shape.kind == "counter":
        return ColumnLook(name, shape, COUNTER, "", "", "", UNKNOWN, ("whole numbers, one more each row",))
    quantity = sense.quantity
    why: tuple[str, ...] = ("by name",) if quantity != UNKNOWN else ()
    if quantity == UNKNOWN and shape.kind == FLAG:
        quantity, why = FLAG, ("two values only",)
    if quantity == UNKNOWN and shape.kind == "constant":
        quantity, why = CONSTANT, (f"always {shape.mean:.6g}",)
    return ColumnLook(name, shape, quantity, sense.kind, sense.part, sense.unit, sense.role or UNKNOWN, why)


def _pair(columns: list[ColumnLook], held: Spectra) -> list[ColumnLook]:
    """Two moving columns of unknown physics, and nothing else: input and output, where it shows which is which."""
    moving = [c for c in columns if c.name in held.samples]
    if len(moving) != 2 or any(c.quantity != UNKNOWN or c.role != UNKNOWN for c in moving):
        return columns
    found = causality(
        moving[0].name, held.samples[moving[0].name], moving[1].name, held.samples[moving[1].name]
    )
    if found is None:
        return _pair_by_name(columns, [c.name for c in moving])
    why = {
        found.input: f"{found.output} answers it, on the average {found.lag:.1f} samples later",
        found.output: f"answers {found.input}; the other way round nothing rings",
    }
    role = {found.input: INPUT, found.output: OUTPUT}
    return [
        replace(c, quantity=role[c.name], role=role[c.name], why=(*c.why, why[c.name]))
        if c.name in role
        else c
        for c in columns
    ]


_INPUT_NAMES, _OUTPUT_NAMES = ("u", "in", "input", "x"), ("y", "out", "output")


def _pair_by_name(columns: list[ColumnLook], names: list[str]) -> list[ColumnLook]:
    """u and y, as the literature calls input and output."""
    roles = {n: INPUT for n in names if n.lower() in _INPUT_NAMES}
    roles |= {n: OUTPUT for n in names if n.lower() in _OUTPUT_NAMES}
    if sorted(roles.values()) != [INPUT, OUTPUT]:
        return columns
    return [
        replace(c, quantity=roles[c.name], role=roles[c.name], why=(*c.why, "by name"))
        if c.name in roles
        else c
        for c in columns
    ]


def _told(column: ColumnLook, relations: Relations, rate_hz: float | None) -> ColumnLook:
    """Add the relations that did not decide anything: they are what the user may judge by."""
    why = list(column.why)
    copy = relations.copies.get(column.name)
    if copy is not None and not any("repeats" in w for w in why):
        why.append(
            f"= {copy.scale:.6g} * {copy.of}"
            + (f" {copy.offset:+.4g}" if abs(copy.offset) > 1e-9 * abs(column.shape.std) else "")
        )
    near = relations.near.get(column.name)
    if near is not None and copy is None:
        why.append(f"nearly {near.scale:.4g} * {near.of} (the rest is {100.0 * near.rest:.2g} %)")
    derivative = relations.derivatives.get(column.name)
    if derivative is not None:
        order = "" if derivative.order == 1 else "second "
        per = "" if rate_hz else " per sample"
        why = [w for w in why if not w.startswith("derivative of")]
        why.append(
            f"{order}derivative of {derivative.of}, times {derivative.factor:.4g}{per} (match {derivative.match:.3f})"
        )
    lead = relations.leads.get(column.name)
    if lead is not None:
        delay = f"{lead.lag / rate_hz * 1e3:.3g} ms" if rate_hz else f"{lead.lag:.2g} samples"
        why.append(f"follows {lead.column} after {delay} (correlation {lead.match:.3f})")
    return replace(column, why=tuple(why))
