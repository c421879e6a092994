"""A camera whose image moves as it turns."""

from stillarm.common.causes.declaration import Cause, Parameter

CAUSE = Cause(
    "camera_tilt_coupling",
    "camera",
    name="a camera whose image moves as it turns",
    sees="the image moves with the angle of the tip as well as with its position",
    note="Without an accelerometer it looks like another participation.",
    equation="replaces camera.rotation_px_per_rad",
    parameters=(Parameter("rotation_px_per_rad", "px a rad", -1e9, 1e9, (50.0, 300.0), signed=True),),
    provoke="a slow move, in which the arm stays straight, and a ring-down.",
    acts="key",
    key="camera.rotation_px_per_rad",
)
