"""Viscous friction other than stated or not proportional to velocity."""

from stillarm.common.causes.driven.declaration import DrivenCause, positive, signed

CAUSE = DrivenCause(
    "joint_viscous_friction",
    name="viscous friction other than stated or not proportional to velocity",
    sees="fast moves ask for another torque than the model says",
    equation="theta'' = ... - (d + c |theta'|) theta'",
    parameters=(
        positive("damping_per_s", "1/s", "damping"),
        signed("square_per_rad", "1/rad", "viscous_square"),
        signed("asymmetry_per_s", "1/s", "viscous_asymmetry"),
    ),
    provoke="move at several constant speeds up to the highest.",
)
