"""From a grey box's numbers to those of the equations of motion: laws of the stepper, pull of the modes."""

from collections.abc import Mapping
from math import exp

import numpy as np
from numpy.typing import NDArray

from stillarm.simulation.arm.torque_joint import LAWS

Array = NDArray[np.float64]
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


def laws_of(numbers: Numbers) -> Array:
    """The numbers of the stepper's laws. Friction is told by its mean over both directions and half the difference."""
    law = {name: numbers.get(name, 0.0) for name in LAWS}
    mean, half = numbers.get("coulomb", 0.0), numbers.get("coulomb_difference", 0.0)
    law["arm_cubic"] += numbers.get("arm_cubic_over_w2", 0.0) * exp(2.0 * numbers.get("log_w_1", 0.0))
    # a turn of the joint is no turn of the angle that is measured: a wave in the place of a ripple's
    if numbers.get("gravity_cycles", 0.0) > 0.0:
        law["ripple_sine"], law["gravity_sine"] = law["gravity_sine"], 0.0
        law["ripple_cosine"], law["gravity_cosine"] = law["gravity_cosine"], 0.0
        law["ripple_cycles"] = numbers["gravity_cycles"]
    law["coulomb_positive"], law["coulomb_negative"] = max(mean + half, 0.0), max(mean - half, 0.0)
    law["stribeck_positive"] = law["stribeck_negative"] = numbers.get("stribeck", 0.0)
    law["stribeck_velocity"] = exp(min(numbers.get("log_stribeck_velocity", 0.0), 10.0))
    return np.array(list(law.values()))
