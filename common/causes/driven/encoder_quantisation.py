"""An encoder with coarse steps."""

from stillarm.common.causes.driven.declaration import DrivenCause

CAUSE = DrivenCause(
    "encoder_quantisation",
    name="an encoder with coarse steps",
    sees="the position moves in steps",
    equation="position = step round(theta / step)",
    numbers=("step",),
    provoke="move slowly over several steps.",
)
