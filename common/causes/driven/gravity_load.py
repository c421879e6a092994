"""Gravity on the joint."""

from stillarm.common.causes.driven.declaration import DrivenCause

CAUSE = DrivenCause(
    "gravity_load",
    name="gravity on the joint",
    sees="the joint falls back to one angle",
    equation="theta'' = ... + a sin(theta) + b cos(theta)",
    numbers=(
        "gravity_sine",
        "gravity_cosine",
    ),
    provoke="hold poses far apart.",
)
