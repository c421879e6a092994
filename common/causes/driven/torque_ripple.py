"""A torque that varies with the joint's angle."""

from stillarm.common.causes.driven.declaration import DrivenCause

CAUSE = DrivenCause(
    "torque_ripple",
    name="a torque that varies with the joint's angle",
    sees="the speed ripples, so many times a turn at every speed",
    equation="theta'' = ... + a sin(n theta) + b cos(n theta)",
    numbers=(
        "ripple_sine",
        "ripple_cosine",
        "ripple_cycles",
    ),
    provoke="turn slowly through the whole range at constant torque.",
)
