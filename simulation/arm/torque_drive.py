"""One cycle of an arm whose joint a torque drives, compiled: the joint pushes the stepper's modes, and they pull at it.

    theta'' = tau - d theta' + f(theta, theta') + sum_i pull_i (2 zeta_i w_i q_i' + w_i^2 q_i)
    lag tau' = gain clip(u) - tau

with the modes' equations and laws as in stepper.py, and f those of torque_joint.py (smooth torques, and dry friction by
Moreau's time stepping). Over a substep theta'' is constant: the modes' pull is that at its middle, extrapolated,
viscous friction the mean of both ends. Errors are of second order in the substep, of first where dry friction turns.
The joint's motion is a stretch as in joint.py, so end stops and the play behind the joint act alike; an arm that is
not in contact pulls at nothing. An input that is no number brakes the joint, as a winding that is shorted does.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from stillarm.common.causes.driven import DRIVEN_CAUSES
from stillarm.common.files.driven_joint import DrivenJoint
from stillarm.common.files.model import Model
from stillarm.common.user_error import UserError
from stillarm.simulation.arm.compiler import compiled, inlined, nth
from stillarm.simulation.arm.joint import move, pressed_on, risen
from stillarm.simulation.arm.state import Record, Records
from stillarm.simulation.arm.stepper import free_acceleration, look, modes_through
from stillarm.simulation.arm.torque_joint import friction_limits, smooth_torque

Array = NDArray[np.float64]
OBEYED = (
    "amplifier_dead_zone",
    "gravity_load",
    "joint_coulomb_friction",
    "joint_stribeck_friction",
    "joint_viscous_friction",
    "torque_offset",
    "torque_ripple",
)
"""The causes of stillarm.common.causes.driven that act between the input and the joint."""
# places in what `joint_numbers` gives; pulls to the end
_GAIN, _DAMPING, _LAG, _LIMIT, _ZONE, _CUT, _TORQUE, _PULLS = range(8)
_LONGEST_S = 1e-4
_TURN = 0.05  # rad of the fastest mode in a substep, at most
_BRAKING_PER_S = 50.0  # d of a joint that is braked: at rest within a tenth of a second
_MOST_PIECES = 8  # of a substep: more would be rounding errors at an end stop


def obeyed_numbers(model: Model, joint: DrivenJoint, name: str) -> dict[str, float]:
    """The joint's own damping and friction by the numbers of causes (stillarm.common.causes.driven), with those of the
    model's effects in their place.

    Raises UserError for an effect that acts on a sensor, or changes what the model states elsewhere.
    """
    hub = joint.hub_inertia_kg_m2
    numbers = {"damping": joint.damping_n_m_s / hub, "coulomb": joint.coulomb_n_m / hub}
    for index, effect in enumerate(model.effects):
        cause = DRIVEN_CAUSES.get(str(effect["cause"]))
        if cause is None:
            continue
        if cause.identifier not in OBEYED:
            raise UserError(
                f"{name}: effects[{index}].cause = {cause.identifier!r}: only `stillarm diagnose` obeys it; the "
                f"simulated joint obeys {', '.join(OBEYED)}: remove it"
            )
        numbers |= cause.numbers_of(effect)
    return numbers


def joint_numbers(joint: DrivenJoint, numbers: Mapping[str, float], pushes_m: Array) -> Array:
    """The joint as `advance_by_input` takes it, (7 + m,), all divided by J_hub; its torque is part of the state.

    numbers: as `obeyed_numbers` gives them. pushes_m: b_i, (m,). pull_i = m_i b_i / J_hub.
    """
    hub = joint.hub_inertia_kg_m2
    carried = np.array(joint.carried_kg_m2)
    pulls = np.divide(carried, pushes_m, out=np.zeros_like(carried), where=carried > 0.0) / hub
    limit = np.inf if joint.limit is None else joint.limit
    zone, cut = numbers.get("dead_zone", 0.0), numbers.get("dead_cut", 0.0)
    head = [joint.torque_per_input / hub, numbers["damping"], joint.lag_s, limit, zone, cut, 0.0]
    return np.array([*head, *pulls])


@inlined
def _pulled(arm: Record, joint: Array, ahead_s: float) -> float:
    """What the modes add to theta'' in so many seconds, by their state now, rad/s^2."""
    if arm.gap != 0.0 and arm.contact == 0.0:
        return 0.0
    total = 0.0
    for i in range(arm.modes):
        pull = joint[_PULLS + i]
        if pull != 0.0:
            mode = nth(arm.mode, i)
            bent = free_acceleration(mode, arm.acceleration, mode.q, mode.v)
            q = mode.q + ahead_s * (mode.v + 0.5 * ahead_s * bent)
            total += pull * (2.0 * mode.sigma * (mode.v + ahead_s * bent) + mode.stiffness * q)
    return total


@compiled
def _accelerated(
    arm: Record, joint: Array, laws: Array, torque: float, damping: float, middle: float, h: float
) -> float:
    """theta'' under a mean torque over a substep of h, rad/s^2. middle: half of h, or 0 for theta'' as it begins."""
    omega = arm.rate
    theta = arm.motor + middle * omega
    free = torque + _pulled(arm, joint, middle) + smooth_torque(laws, theta, omega)
    alpha = (free - damping * omega) / (1.0 + damping * middle)
    forward, backward = friction_limits(laws, omega)
    if forward > 0.0 or backward > 0.0:
        alpha += min(max(-(omega / h + alpha), -forward), backward)
    return 0.0 if pressed_on(arm, alpha) else alpha


@inlined
def _passed(joint: Array, value: float) -> float:
    """What an amplifier passes of an input: a dead zone, one that opens at once, a limit."""
    size: float = max(abs(value) - joint[_ZONE], 0.0)
    if size <= joint[_CUT]:
        size = 0.0
    size = min(size, joint[_LIMIT])
    return size if value > 0.0 else -size


@compiled
def _driven(arm: Record, joint: Array, laws: Array, t: float, span: float, value: float) -> None:
    """Move on by a part of a cycle over which the input is held."""
    braked = np.isnan(value)
    wanted = 0.0 if braked else joint[_GAIN] * _passed(joint, value)
    damping = joint[_DAMPING] + (_BRAKING_PER_S if braked else 0.0)
    longest = _LONGEST_S
    for i in range(arm.modes):
        longest = min(longest, _TURN / (2.0 * np.pi * nth(arm.mode, i).hz))
    parts = int(np.ceil(span / longest))
    for part in range(parts):
        h = span / parts
        lag = joint[_LAG]
        left = joint[_TORQUE] - wanted
        mean = wanted if lag == 0.0 else wanted + left * risen(1.0 / lag, h) / h
        joint[_TORQUE] = wanted if lag == 0.0 else wanted + left * np.exp(-h / lag)
        begun = t + part * h
        for _ in range(_MOST_PIECES):
            if h <= 0.0:
                break
            used, count = move(arm, h, 0.0, _accelerated(arm, joint, laws, mean, damping, 0.5 * h, h), 0)
            modes_through(arm, begun, count)
            begun += used
            h -= used


@compiled
def advance_by_input(
    arms: Records, joint: Array, laws: Array, t: float, early: float, late: float, seen: Array
) -> None:
    """A cycle under a drive's input, and what there is to see at its end (stepper.look). t: from the recording's start,
    s.

    joint, laws: as `joint_numbers` and `torque_joint.laws_of` give them; the torque in `joint` moves on. early, late:
    input before and after a command's arrival in the cycle, in its unit.
    """
    arm = arms[0]
    _driven(arm, joint, laws, t, arm.early, early)
    _driven(arm, joint, laws, t + arm.early, arm.late, late)
    arm.acceleration = _accelerated(arm, joint, laws, joint[_TORQUE], joint[_DAMPING], 0.0, _LONGEST_S)
    look(arms, t + arm.early + arm.late, seen)
