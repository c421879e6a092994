"""A sensor's scale that is wrong."""

from stillarm.common.causes.driven.declaration import DrivenCause

CAUSE = DrivenCause(
    "sensor_scale",
    name="a sensor's scale that is wrong",
    sees="one sensor shows a constant multiple of what another does",
    equation="reading = scale * value",
    numbers=("scale",),
    provoke="move between two stops of known distance.",
)
