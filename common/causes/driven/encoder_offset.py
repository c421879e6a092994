"""An encoder's zero that is off."""

from stillarm.common.causes.driven.declaration import DrivenCause, of_channel, signed

CAUSE = DrivenCause(
    "encoder_offset",
    name="an encoder's zero that is off",
    sees="gravity and ripple sit at other angles than stated",
    equation="position = theta + offset",
    parameters=(
        signed("offset_rad", "rad", "offset {channel}", required=True),
        of_channel(),
    ),
    provoke="move to a mechanical stop of known angle.",
    repeatable=True,
)
