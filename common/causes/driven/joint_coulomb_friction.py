"""Dry friction in the joint."""

from stillarm.common.causes.driven.declaration import DrivenCause

CAUSE = DrivenCause(
    "joint_coulomb_friction",
    name="dry friction in the joint",
    sees="the joint sticks where it turns, and asks for the same torque at every speed",
    equation="theta'' = ... - c sign(theta')",
    numbers=("coulomb",),
    provoke="move to and fro at several constant speeds, slow ones among them.",
    confused_with={
        "joint_stribeck_friction": "creep at speeds down to the slowest, and let the joint break loose from rest"
    },
)
