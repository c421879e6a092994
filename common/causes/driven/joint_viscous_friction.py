"""Viscous friction other than stated or not proportional to velocity."""

from stillarm.common.causes.driven.declaration import DrivenCause

CAUSE = DrivenCause(
    "joint_viscous_friction",
    name="viscous friction other than stated or not proportional to velocity",
    sees="fast moves ask for another torque than the model says",
    equation="theta'' = ... - (d + c |theta'|) theta'",
    numbers=("damping",),
    provoke="move at several constant speeds up to the highest.",
)
