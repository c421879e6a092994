"""A rotor that is out of balance."""

import numpy as np

from stillarm.common.causes.declaration import PHASE, Cause, Parameter, size


def law(
    t: float,
    theta: float,
    omega: float,
    q: float,
    v: float,
    w: float,
    gear_ratio: float,
    imbalance_m: float,
    phase_rad: float,
) -> float:
    """Acceleration of the first mode, m/s^2."""
    speed = gear_ratio * omega
    push: float = imbalance_m * speed * speed * np.sin(gear_ratio * theta + phase_rad)
    return push


CAUSE = Cause(
    "rotor_imbalance",
    "drive",
    name="a rotor that is out of balance",
    sees=(
        "while the joint turns steadily the arm shakes at the motor's own speed, harder the faster it turns, and is "
        "left alone at rest"
    ),
    note="The motor turns gear_ratio times as fast as the joint.",
    equation="q_1'' = ... + imbalance (N theta')^2 sin(N theta + phase), N = gear ratio",
    parameters=(
        Parameter(
            "gear_ratio", "1", 1.0, 1000.0, (30.0, 120.0), tried=tuple(np.geomspace(30.0, 120.0, 12).tolist())
        ),
        size("imbalance_m", "m", 1.0, 1e-4, 1e-3),
        PHASE,
    ),
    provoke="long moves at several steady speeds, one of which turns the motor at the arm's own frequency.",
    acts="force",
    foreign=True,
    law=law,
    confused_with={
        "periodic_disturbance": (
            "record a rest and moves at two speeds: a foreign force goes on at rest and keeps its frequency, an "
            "imbalance follows the speed"
        ),
    },
)
