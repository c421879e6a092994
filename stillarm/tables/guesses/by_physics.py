"""Quantities passed on along copies, derivatives and answers: what is named tells what the nameless beside it is."""

from dataclasses import replace

from stillarm.tables.guesses.column_look import ColumnLook
from stillarm.tables.guesses.derivative import Derivative
from stillarm.tables.guesses.lead import Lead
from stillarm.tables.guesses.names import (
    ANGLE,
    ANGULAR_ACCELERATION,
    CONSTANT,
    VELOCITY,
    matrix_of,
    without_kind,
)
from stillarm.tables.guesses.relations import Relations
from stillarm.tables.guesses.shape import TURNS, encoder_counts
from stillarm.tables.roles import UNKNOWN

_ANSWERS = 0.95  # correlation of a command with its answer
_NEXT = {ANGLE: VELOCITY, VELOCITY: ANGULAR_ACCELERATION}
_BEFORE = {velocity: angle for angle, velocity in _NEXT.items()}


def by_physics(columns: list[ColumnLook], relations: Relations) -> list[ColumnLook]:
    """Pass quantities on along copies and derivatives, until nothing changes."""
    held = {column.name: column for column in columns}
    for _ in range(3):
        for copy in relations.copies.values():
            _share(held, copy.column, copy.of, "repeats")
        for derivative in relations.derivatives.values():
            _derive(held, derivative)
    for column in [c for c in held.values() if c.quantity == UNKNOWN]:
        _name_unknown_pair(held, column, relations)
    for column in list(held.values()):
        _angle_by_step(held, column)
        _measured_by_step(held, column)
    for _ in range(2):
        for derivative in relations.derivatives.values():
            _derive(held, derivative)
        for lead in relations.leads.values():
            _command_and_answer(held, lead)
    _by_sibling(held)
    return list(held.values())


def _share(held: dict[str, ColumnLook], one: str, other: str, word: str) -> None:
    a, b = held[one], held[other]
    if a.quantity == UNKNOWN != b.quantity:
        held[one] = replace(
            a,
            quantity=b.quantity,
            kind=a.kind or b.kind,
            part=a.part or b.part,
            why=(*a.why, f"{word} {other}"),
        )
    elif b.quantity == UNKNOWN != a.quantity:
        held[other] = replace(
            b,
            quantity=a.quantity,
            kind=b.kind or a.kind,
            part=b.part or a.part,
            why=(*b.why, f"{word} {one}"),
        )


def _derive(held: dict[str, ColumnLook], derivative: Derivative) -> None:
    rate, state = held[derivative.column], held[derivative.of]
    if derivative.order != 1:
        return
    if rate.quantity in (UNKNOWN, "velocity") and state.quantity in _NEXT:
        held[rate.name] = replace(
            rate,
            quantity=_NEXT[state.quantity],
            part=state.part,
            why=(*rate.why, f"derivative of {state.name}"),
        )
    elif state.quantity in (UNKNOWN, "position") and rate.quantity in _BEFORE:
        held[state.name] = replace(
            state,
            quantity=_BEFORE[rate.quantity],
            part=rate.part,
            why=(*state.why, f"{rate.name} is its derivative"),
        )


def _name_unknown_pair(held: dict[str, ColumnLook], column: ColumnLook, relations: Relations) -> None:
    """Two nameless columns, one the derivative of the other: a position and a velocity, of what is not known."""
    derivative = relations.derivatives.get(column.name)
    if (
        derivative is None
        or derivative.order != 1
        or held[derivative.of].quantity not in (UNKNOWN, "position")
    ):
        return
    state = held[derivative.of]
    held[state.name] = replace(
        state, quantity="position", why=(*state.why, f"{column.name} is its derivative")
    )
    held[column.name] = replace(column, quantity="velocity", why=(*column.why, f"derivative of {state.name}"))


def _angle_by_step(held: dict[str, ColumnLook], column: ColumnLook) -> None:
    """A step of 2 pi / N is an encoder's, and the column an angle in rad: no converter has an irrational step."""
    if column.quantity not in (UNKNOWN, "position") or column.shape.step is None:
        return
    counts = encoder_counts(column.shape.step, TURNS["rad"])
    if counts is not None:
        why = f"angle in rad: its step is 1/{counts} of a turn"
        held[column.name] = replace(column, quantity=ANGLE, unit="rad", why=(*column.why, why))


def _has_encoder_step(column: ColumnLook) -> bool:
    return column.shape.step is not None and encoder_counts(column.shape.step, TURNS["rad"]) is not None


def _measured_by_step(held: dict[str, ColumnLook], column: ColumnLook) -> None:
    """A matrix that is named a model, but has a column with an encoder's step, was measured."""
    if column.kind != "modelled" or not _has_encoder_step(column):
        return
    for other in list(held.values()):
        if other.kind == "modelled" and matrix_of(other.name) == matrix_of(column.name):
            why = f"measured, whatever its name says: {column.name} has an encoder's step"
            held[other.name] = replace(other, kind="measured", why=(*other.why, why))


def _command_and_answer(held: dict[str, ColumnLook], lead: Lead) -> None:
    """Two columns of one matrix: one follows the other, later and with nearly the same shape: command and measurement.

    A column that is named a command, and whose answer is known, commands that quantity.
    """
    first, second = held[lead.column], held[lead.follower]
    if lead.match < _ANSWERS:
        return
    if first.quantity == UNKNOWN and first.shape.step is None and _has_encoder_step(second):
        why = f"command, whatever its name says: {second.name}, which has an encoder's step, follows it"
        first = replace(
            first, kind="command", why=first.why if first.kind == "command" else (*first.why, why)
        )
    if (
        first.quantity == UNKNOWN
        and first.kind == "command"
        and second.quantity not in (UNKNOWN, "position", "velocity")
    ):
        held[first.name] = first = replace(
            first,
            quantity=second.quantity,
            part=second.part,
            unit=second.unit,
            why=(*first.why, f"{second.name} follows it"),
        )
    if (
        first.quantity == second.quantity != UNKNOWN
        and not first.kind
        and not second.kind
        and matrix_of(first.name) == matrix_of(second.name)
    ):
        held[first.name] = replace(first, kind="command", why=(*first.why, f"{second.name} follows it"))
        held[second.name] = replace(second, kind="measured")


def _by_sibling(held: dict[str, ColumnLook]) -> None:
    """A command of unknown quantity beside a measurement whose name differs in that word alone: X_ref, X_meas."""
    known = {
        without_kind(c.name): c
        for c in held.values()
        if c.kind != "command" and c.quantity not in (UNKNOWN, CONSTANT)
    }
    for column in list(held.values()):
        beside = known.get(without_kind(column.name))
        if column.quantity == UNKNOWN and column.kind == "command" and beside is not None:
            why = f"as {beside.name} by name"
            held[column.name] = replace(
                column,
                quantity=beside.quantity,
                part=beside.part,
                unit=column.unit or beside.unit,
                why=(*column.why, why),
            )
