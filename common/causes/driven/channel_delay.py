"""A delay between channels."""

from stillarm.common.causes.driven.declaration import DrivenCause

CAUSE = DrivenCause(
    "channel_delay",
    name="a delay between channels",
    sees="one channel follows the others by a constant time",
    equation="reading(t) = value(t - delay)",
    numbers=("delay",),
    provoke="drive with steps, and record all channels by one clock.",
)
