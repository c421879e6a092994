"""Friction that is larger at rest."""

from stillarm.common.causes.driven.declaration import DrivenCause, positive, signed

CAUSE = DrivenCause(
    "joint_stribeck_friction",
    name="friction that is larger at rest",
    sees="the joint breaks loose with a jerk and needs less torque once it moves",
    equation="theta'' = ... - (c + s exp(-(theta' / v)^2)) sign(theta')",
    parameters=(
        positive("coulomb_rad_s2", "rad/s^2", "coulomb", required=True),
        signed("at_rest_rad_s2", "rad/s^2", "stribeck", required=True),
        positive("velocity_rad_s", "rad/s", "log_stribeck_velocity", required=True, logarithm=True),
    ),
    provoke="creep at speeds down to the slowest.",
)
