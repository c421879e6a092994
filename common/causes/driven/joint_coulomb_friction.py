"""Dry friction in the joint."""

from stillarm.common.causes.driven.declaration import DrivenCause, positive, signed

CAUSE = DrivenCause(
    "joint_coulomb_friction",
    name="dry friction in the joint",
    sees="the joint sticks where it turns, and asks for the same torque at every speed",
    equation="theta'' = ... - c sign(theta')",
    parameters=(
        positive("coulomb_rad_s2", "rad/s^2", "coulomb", required=True),
        signed("difference_rad_s2", "rad/s^2", "coulomb_difference"),
    ),
    provoke="move to and fro at several constant speeds, slow ones among them.",
    confused_with={
        "joint_stribeck_friction": "creep at speeds down to the slowest, and let the joint break loose from rest"
    },
)
