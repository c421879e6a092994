"""Gravity on the joint."""

from stillarm.common.causes.driven.declaration import DrivenCause, signed

CAUSE = DrivenCause(
    "gravity_load",
    name="gravity on the joint",
    sees="the joint falls back to one angle",
    equation="theta'' = ... + a sin(theta) + b cos(theta)",
    parameters=(
        signed("sine_rad_s2", "rad/s^2", "gravity_sine"),
        signed("cosine_rad_s2", "rad/s^2", "gravity_cosine"),
    ),
    provoke="hold poses far apart.",
)
