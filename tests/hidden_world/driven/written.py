"""A case as tables: how each column is called, its numbers, and the role that a careful user gives it."""

from dataclasses import dataclass

import numpy as np

from tests.hidden_world.driven.case import Case
from tests.hidden_world.driven.rig import Channel, Values, luck

_COMMAND_ROLE = {
    "torque": ("joint_torque_command_n_m", "N m"),
    "current": ("motor_current_command_a", "A"),
    "voltage": ("motor_voltage_v", "V"),
}
ROLE = {
    "position": "joint_position_rad",
    "motor_position": "motor_position_rad",
    "velocity": "joint_velocity_rad_s",
    "deflection": "deflection_m",
    "strain": "strain",
    "acceleration": "acceleration_m_s2",
}
_NAMES = {
    "torque": ("tau", "torque", "u", "T_cmd"),
    "current": ("i_ref", "current", "u", "I_cmd"),
    "voltage": ("Vm", "voltage", "u", "V_motor"),
    "position": ("theta", "position", "q", "enc"),
    "motor_position": ("theta_m", "motor_angle", "enc_m", "phi"),
    "velocity": ("omega", "velocity", "dq", "tacho"),
    "deflection": ("tip", "deflection", "w", "y"),
    "strain": ("strain", "gauge", "sg", "ain3"),
    "acceleration": ("acc", "a_tip", "accel", "ax"),
}


@dataclass(frozen=True)
class Column:
    """role, unit, scale: of the description; unit "" where the scale says it. printed: the unit as in a header."""

    name: str
    values: Values
    role: str
    unit: str
    printed: str
    scale: float | None = None
    whole: bool = False


def columns(case: Case) -> list[Column]:
    """The command first, then the channels, in the order in which they are logged."""
    chance = luck(case.rig.seed, 21)
    out = [_command(case, chance)]
    for channel in case.rig.channels:
        out.append(_measured(channel, case.recording.channels[channel.kind], chance))
    order = chance.permutation(len(out)) if chance.random() < 0.4 else np.arange(len(out))
    return [out[k] for k in order]


def time_s(case: Case) -> Values:
    return np.arange(case.rig.rows) / case.rig.rate_hz


def _command(case: Case, chance: np.random.Generator) -> Column:
    drive = case.rig.drive
    role, unit = _COMMAND_ROLE[drive.kind]
    name = str(chance.choice(_NAMES[drive.kind]))
    values = case.recording.command / drive.log_size
    if drive.log_unit == "si":
        return Column(name, values, role, unit, unit)
    whole = drive.log_unit == "counts"
    printed = "counts" if whole else "%"
    return Column("u" if chance.random() < 0.5 else name, values, role, "unknown", printed, whole=whole)


def _measured(channel: Channel, values: Values, chance: np.random.Generator) -> Column:
    name, role = str(chance.choice(_NAMES[channel.kind])), ROLE[channel.kind]
    numbers = values / channel.size
    if channel.unit == "counts":
        return Column(name, numbers, role, "", "counts", channel.size, whole=channel.quantum == channel.size)
    if channel.unit.endswith("_v"):
        return Column(name, numbers, role, "unknown", "V")
    return Column(name, numbers, role, channel.unit, channel.unit)
