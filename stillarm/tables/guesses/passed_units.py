"""Units: by size where nothing states them, then passed on along derivatives, copies and neighbours."""

from dataclasses import replace

from stillarm.tables.guesses.column_look import ColumnLook
from stillarm.tables.guesses.copies import Copy
from stillarm.tables.guesses.derivative import Derivative
from stillarm.tables.guesses.names import ACCELERATION, COUNTER, FLAG, matrix_of, without_kind
from stillarm.tables.guesses.relations import Relations
from stillarm.tables.guesses.units_by_size import gravity_unit, size_unit
from stillarm.tables.roles import UNKNOWN
from stillarm.tables.table import Table, as_floats
from stillarm.tables.units import size_of

_ONE = 0.1  # a factor this near to 1 leaves the unit as it is
_PER_SECOND = {"rad": "rad/s", "deg": "deg/s", "m": "m/s", "mm": "mm/s"}


def with_units(columns: list[ColumnLook], table: Table, relations: Relations) -> list[ColumnLook]:
    axes = [as_floats(table.columns[c.name]) for c in columns if c.quantity == ACCELERATION and not c.unit]
    found = []
    for column in columns:
        unit, why = column.unit, ""
        if not unit and column.shape.kind != "constant":
            unit, why = (
                gravity_unit(axes)
                if column.quantity == ACCELERATION
                else size_unit(column.quantity, column.shape)
            )
        found.append(replace(column, unit=unit, why=(*column.why, *([f"{unit}: {why}"] if why else []))))
    held = {column.name: column for column in found}
    for _ in range(3):
        for derivative in relations.derivatives.values():
            _unit_by_derivative(held, derivative)
        for copy in relations.copies.values():
            _unit_by_copy(held, copy)
        _unit_by_companion(held)
    return list(held.values())


def _unit_by_derivative(held: dict[str, ColumnLook], derivative: Derivative) -> None:
    """A factor of 1 between rate and state: the same unit, per second."""
    rate, state = held[derivative.column], held[derivative.of]
    if derivative.order != 1 or not abs(abs(derivative.factor) - 1.0) < _ONE:
        return
    per_second = {per: unit for unit, per in _PER_SECOND.items()}
    if state.unit in _PER_SECOND and not rate.unit:
        unit = _PER_SECOND[state.unit]
        held[rate.name] = replace(
            rate, unit=unit, why=(*rate.why, f"{unit}: as {state.name}, with a factor of 1")
        )
    elif rate.unit in per_second and not state.unit:
        unit = per_second[rate.unit]
        held[state.name] = replace(
            state, unit=unit, why=(*state.why, f"{unit}: as {rate.name}, with a factor of 1")
        )


def _unit_by_copy(held: dict[str, ColumnLook], copy: Copy) -> None:
    """A copy with a factor of 1 has the same unit; one with that of another unit of the dimension has that one."""
    for one, other, scale in (
        (copy.column, copy.of, copy.scale),
        (copy.of, copy.column, 1.0 / copy.scale if copy.scale else 0.0),
    ):
        mine, theirs = held[one], held[other]
        size = size_of(theirs.unit) if theirs.unit else None
        if mine.unit or size is None:
            continue
        for unit in (theirs.unit, "rad", "deg", "m", "mm", "m/s2", "g", "A", "mA"):
            candidate = size_of(unit)
            if (
                candidate
                and candidate[0] == size[0]
                and abs(abs(scale) * candidate[1] / size[1] - 1.0) < 0.002
            ):
                held[one] = replace(
                    mine,
                    unit=unit,
                    why=(*mine.why, f"{unit}: repeats {other} in {theirs.unit} times {scale:.4g}"),
                )
                break


def _unit_by_companion(held: dict[str, ColumnLook]) -> None:
    """A unit that shows in one column holds for columns of the same quantity and the same stem of the name."""
    for column in list(held.values()):
        if column.unit or column.quantity in (UNKNOWN, FLAG, COUNTER) or column.shape.kind == "constant":
            continue
        beside = {
            c.unit
            for c in held.values()
            if c.unit and c.quantity == column.quantity and _alike(c.name, column.name)
        }
        if len(beside) == 1:
            unit = beside.pop()
            held[column.name] = replace(column, unit=unit, why=(*column.why, f"{unit}: as its neighbours"))


def _alike(one: str, other: str) -> bool:
    """Whether names differ only in a number, an axis, or the word for command and measurement."""
    return _stem(one) == _stem(other) or without_kind(one) == without_kind(other)


def _stem(name: str) -> str:
    return matrix_of(name).rstrip("0123456789_xyzXYZ. ")
