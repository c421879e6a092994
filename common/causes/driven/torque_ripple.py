"""A torque that varies with the joint's angle."""

from stillarm.common.causes.driven.declaration import DrivenCause, positive, signed

CAUSE = DrivenCause(
    "torque_ripple",
    name="a torque that varies with the joint's angle",
    sees="the speed ripples, so many times a turn at every speed",
    equation="theta'' = ... + a sin(n theta) + b cos(n theta)",
    parameters=(
        signed("sine_rad_s2", "rad/s^2", "ripple_sine"),
        signed("cosine_rad_s2", "rad/s^2", "ripple_cosine"),
        positive("cycles_per_rad", "1/rad", "ripple_cycles", required=True),
    ),
    provoke="turn slowly through the whole range at constant torque.",
)
