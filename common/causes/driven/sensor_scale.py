"""A sensor's scale that is wrong."""

from stillarm.common.causes.driven.declaration import DrivenCause, of_channel, signed

CAUSE = DrivenCause(
    "sensor_scale",
    name="a sensor's scale that is wrong",
    sees="one sensor shows a constant multiple of what another does",
    equation="reading = scale * value",
    parameters=(
        signed("scale", "1", "scale {channel}", required=True),
        of_channel(),
    ),
    provoke="move between two stops of known distance.",
    repeatable=True,
)
