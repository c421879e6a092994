"""An encoder's zero that is off."""

from stillarm.common.causes.driven.declaration import DrivenCause

CAUSE = DrivenCause(
    "encoder_offset",
    name="an encoder's zero that is off",
    sees="gravity and ripple sit at other angles than stated",
    equation="position = theta + offset",
    numbers=("offset",),
    provoke="move to a mechanical stop of known angle.",
)
