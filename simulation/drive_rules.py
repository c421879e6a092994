"""The causes that change what the drive makes of a command: a dead band, friction that costs velocity."""

from math import copysign

from common.effects import effect_of
from common.model import Model
from simulation.plant_effects import CommandRule


def command_rules(model: Model) -> list[CommandRule]:
    """The rules that a model's effects name, in the order in which they apply."""
    rules: list[CommandRule] = []
    if band := effect_of(model, "drive_deadband"):
        rules.append(dead_band(band["deadband_rad_s"]))
    if friction := effect_of(model, "joint_friction"):
        rules.append(velocity_loss(friction["velocity_loss_rad_s"]))
    return rules


def dead_band(deadband_rad_s: float) -> CommandRule:
    """A command of |c| <= deadband is obeyed as 0, others unchanged."""
    return lambda command: 0.0 if 0.0 < abs(command) <= deadband_rad_s else command


def velocity_loss(loss_rad_s: float) -> CommandRule:
    """A command c is obeyed as sign(c) max(0, |c| - loss)."""
    return lambda command: copysign(max(0.0, abs(command) - loss_rad_s), command)
