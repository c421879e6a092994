"""Friction that is larger at rest."""

from stillarm.common.causes.driven.declaration import DrivenCause

CAUSE = DrivenCause(
    "joint_stribeck_friction",
    name="friction that is larger at rest",
    sees="the joint breaks loose with a jerk and needs less torque once it moves",
    equation="theta'' = ... - (c + s exp(-(theta' / v)^2)) sign(theta')",
    numbers=(
        "coulomb",
        "stribeck",
        "log_stribeck_velocity",
    ),
    provoke="creep at speeds down to the slowest.",
)
