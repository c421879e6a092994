"""Turns quantities into the roles of a recording. Each role goes to one column; the others stay "unknown"."""

from dataclasses import replace

from stillarm.tables.guesses.column_look import ColumnLook
from stillarm.tables.guesses.names import (
    ACCELERATION,
    ANGLE,
    CURRENT,
    DEFLECTION,
    DISPLACEMENT,
    STRAIN,
    TORQUE,
    VELOCITY,
    VOLTAGE,
)
from stillarm.tables.roles import BY_NAME, INPUT, OUTPUT, UNKNOWN
from stillarm.tables.roles import STRAIN as STRAIN_ROLE
from stillarm.tables.units import size_of

_BY_QUANTITY = {
    (ACCELERATION, ""): "acceleration_m_s2",
    (ANGLE, ""): "joint_position_rad",
    (VELOCITY, ""): "joint_velocity_rad_s",
    (VELOCITY, "command"): "joint_velocity_command_rad_s",
    (TORQUE, ""): "joint_torque_n_m",
    (TORQUE, "command"): "joint_torque_command_n_m",
    (CURRENT, ""): "motor_current_a",
    (CURRENT, "command"): "motor_current_command_a",
    (VOLTAGE, ""): "motor_voltage_v",
    (VOLTAGE, "command"): "motor_voltage_v",
    (STRAIN, ""): STRAIN_ROLE,
    (DEFLECTION, ""): "deflection_m",
    (DISPLACEMENT, ""): "displacement_px",
}


_LARGEST = 1e15  # beyond any measurement, in any unit: stillarm.tables.importing refuses it in a role


def assign_roles(columns: list[ColumnLook]) -> list[ColumnLook]:
    """Give each role to one column that moves: the first of its like; of accelerations the liveliest."""
    columns = _lone_roles_off([_too_large_off(column) for column in columns])
    found = list(columns)
    taken = {column.role for column in columns if column.role != UNKNOWN}
    order = sorted(range(len(columns)), key=lambda i: _rank(columns[i]))
    for index in order:
        column = columns[index]
        if column.role != UNKNOWN:
            continue
        role = _role(column)
        if role == UNKNOWN:
            continue
        if column.shape.kind == "constant":
            found[index] = replace(column, why=(*column.why, "never changes: no role"))
        elif role in taken:
            found[index] = replace(column, why=(*column.why, f"{role} is taken: no role"))
        else:
            taken.add(role)
            found[index] = replace(column, role=role)
    return found


def _too_large_off(column: ColumnLook) -> ColumnLook:
    if column.role == UNKNOWN or not max(abs(column.shape.low), abs(column.shape.high)) > _LARGEST:
        return column
    return replace(column, role=UNKNOWN, why=(*column.why, "too large for a measurement: no role"))


def _lone_roles_off(columns: list[ColumnLook]) -> list[ColumnLook]:
    """An input without an output, or the other way round, is no pair."""
    if {INPUT, OUTPUT} <= {column.role for column in columns}:
        return columns
    return [replace(c, role=UNKNOWN) if c.role in (INPUT, OUTPUT) else c for c in columns]


def _rank(column: ColumnLook) -> tuple[bool, float]:
    """What is named comes before what was found to repeat it; of accelerations the liveliest axis."""
    return "by name" not in column.why, -column.shape.std if column.quantity == ACCELERATION else 0.0


def _role(column: ColumnLook) -> str:
    if max(abs(column.shape.low), abs(column.shape.high)) > _LARGEST:
        return UNKNOWN
    if column.kind == "modelled" or (column.part in ("tip", "link") and column.quantity in (ANGLE, VELOCITY)):
        return UNKNOWN
    if column.quantity == ANGLE and column.part == "motor":
        return "motor_position_rad" if column.kind != "command" else UNKNOWN
    if column.quantity == VELOCITY and column.part == "motor":
        return UNKNOWN
    role = _BY_QUANTITY.get((column.quantity, "command" if column.kind == "command" else ""), UNKNOWN)
    if role == "deflection_m" and not _fits(column.unit, "m"):
        return STRAIN_ROLE
    return (
        role if role == UNKNOWN or not column.unit or _fits(column.unit, BY_NAME[role].dimension) else UNKNOWN
    )


def _fits(unit: str, dimension: str) -> bool:
    size = size_of(unit)
    return not dimension or (size is not None and size[0] == dimension)
