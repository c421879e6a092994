"""A delay between channels."""

from stillarm.common.causes.driven.declaration import DrivenCause, of_channel, signed

CAUSE = DrivenCause(
    "channel_delay",
    name="a delay between channels",
    sees="one channel follows the others by a constant time",
    equation="reading(t) = value(t - delay)",
    parameters=(
        signed("delay_s", "s", "delay {channel}", required=True),
        of_channel(required=False),
    ),
    provoke="drive with steps, and record all channels by one clock.",
    repeatable=True,
)
