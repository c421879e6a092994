"""A filter in a sensor."""

from stillarm.common.causes.driven.declaration import DrivenCause, of_channel, positive

CAUSE = DrivenCause(
    "sensor_lag",
    name="a filter in a sensor",
    sees="one sensor follows the others late and smoothed",
    equation="lag reading' = value - reading",
    parameters=(
        positive("lag_s", "s", "lag {channel}", required=True),
        of_channel(),
    ),
    provoke="drive with a chirp up to the highest frequency.",
    confused_with={
        "channel_delay": "drive with a chirp up to the highest frequency: a filter takes off amplitude, a delay not"
    },
    repeatable=True,
)
