"""From a grey box's numbers to those of the equations of motion: pull of the modes, and which laws are torques."""

from collections.abc import Mapping

from stillarm.simulation.arm.torque_joint import LAWS

Numbers = Mapping[str, float]

_OF_ARM = ("arm_cubic", "arm_coulomb")
_NO_TORQUE = ("stribeck_velocity", "ripple_cycles", *_OF_ARM)
OF_JOINT = [k for k, name in enumerate(LAWS) if name not in _NO_TORQUE]
"""Torques at the joint over its inertia: another inertia leaves the torque as it is."""
_LEAST_FOLLOWS = 1e-12  # below it a mode does not follow the joint: against a division by zero


def pull_of(numbers: Numbers, mode: int) -> float:
    """How a mode pulls at the joint, by the inertia that it carries over the hub's, which no sensor's sign changes."""
    follows = numbers[f"follows_{mode}"]
    return carried_by(numbers, mode) / follows if abs(follows) > _LEAST_FOLLOWS else 0.0


def carried_by(numbers: Numbers, mode: int) -> float:
    """The inertia that a mode carries, over the hub's. Where a model states how the tip follows the joint
    (`stated_follows_I`), another participation carries another inertia: m (participation length)^2."""
    carries, stated = numbers[f"carries_{mode}"], numbers.get(f"stated_follows_{mode}", 0.0)
    return carries * (numbers[f"follows_{mode}"] / stated) ** 2 if stated else carries
