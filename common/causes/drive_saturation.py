"""A drive that stops at a lower speed than declared."""

from stillarm.common.causes.declaration import Cause, replacing

CAUSE = Cause(
    "drive_saturation",
    "drive",
    name="a drive that stops at a lower speed than declared",
    sees="fast moves are cut off at a velocity below the declared limit",
    equation="replaces drive.max_velocity_rad_s",
    parameters=(replacing("max_velocity_rad_s", "rad/s", 1e-06, 1e9, 0.05, 0.15),),
    provoke="a move at the fastest velocity that is in use.",
    acts="key",
    key="drive.max_velocity_rad_s",
)
