"""The motion of a rig with its effects, as the sensors need it."""

from dataclasses import dataclass

import numpy as np

from tests.hidden_world.rigs.arm_effects import change
from tests.hidden_world.rigs.dynamics import LINK, LINK_W, MOTOR, MOTOR_W, MOUNT, SIDE, Q, kinetics
from tests.hidden_world.rigs.inputs import Inputs, plain_inputs
from tests.hidden_world.rigs.moves import Move
from tests.hidden_world.rigs.rig import SLOPES, STEP_S, Effect, Rig, Values


@dataclass(frozen=True)
class Motion:
    """At all ends of steps, shape (steps + 1,). tip: s''; slope: of the tip against the joint, rad; side, mount: the
    oscillators beside the arm. asked: a value a cycle."""

    time_s: Values
    asked: Values
    motor_rad: Values
    motor_rad_s: Values
    link_rad: Values
    link_rad_s: Values
    bending_m: Values
    slope_rad: Values
    s_m: Values
    tip_m_s2: Values
    side_m: Values
    mount_m: Values


def move(rig: Rig, moves: list[Move], effects: tuple[Effect, ...] = (), nuisance: bool = True) -> Motion:
    """What the arm does."""
    inputs = change(plain_inputs(rig, moves, nuisance), effects, rig)
    return motion_of(rig, inputs)


def motion_of(rig: Rig, inputs: Inputs) -> Motion:
    rows, tip = kinetics(
        inputs.start, inputs.delayed(), inputs.force, inputs.stiff, inputs.damp, inputs.laws, inputs.modes
    )
    count = len(inputs.modes)
    bends = rows[:, Q : Q + count]
    bending = np.sum(bends, axis=1)
    slope = bends @ np.array(SLOPES[:count]) / rig.length_m
    link, link_w = (LINK, LINK_W)
    return Motion(
        np.arange(len(tip)) * STEP_S,
        inputs.asked,
        rows[:, MOTOR].copy(),
        rows[:, MOTOR_W].copy(),
        rows[:, link].copy(),
        rows[:, link_w].copy(),
        bending,
        slope,
        rig.length_m * rows[:, link] + bending,
        tip,
        rows[:, SIDE].copy(),
        rows[:, MOUNT].copy(),
    )
