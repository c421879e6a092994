"""Gravity on the joint."""

from stillarm.common.causes.driven.declaration import DrivenCause, positive, signed

CAUSE = DrivenCause(
    "gravity_load",
    name="gravity on the joint",
    sees="the joint falls back to one angle",
    equation="theta'' = ... + a sin(n theta) + b cos(n theta), n = 1 but behind a gear that nobody has stated",
    parameters=(
        signed("sine_rad_s2", "rad/s^2", "gravity_sine"),
        signed("cosine_rad_s2", "rad/s^2", "gravity_cosine"),
        positive("cycles_per_rad", "1/rad", "gravity_cycles"),
    ),
    provoke="hold poses far apart.",
)
