"""An encoder with coarse steps."""

from stillarm.common.causes.driven.declaration import DrivenCause, of_channel, positive

CAUSE = DrivenCause(
    "encoder_quantisation",
    name="an encoder with coarse steps",
    sees="the position moves in steps",
    equation="position = step round(theta / step)",
    parameters=(
        positive("step", "the channel's", "step {channel}", required=True),
        of_channel(),
    ),
    provoke="move slowly over several steps.",
    repeatable=True,
)
