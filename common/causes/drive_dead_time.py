"""A drive that answers later than declared."""

from stillarm.common.causes.declaration import Cause, replacing

CAUSE = Cause(
    "drive_dead_time",
    "drive",
    name="a drive that answers later than declared",
    sees="the joint answers its command later than declared, by the same time at every frequency",
    equation="replaces drive.dead_time_s",
    parameters=(replacing("dead_time_s", "s", 0.0, 1.0, 0.01, 0.04),),
    provoke="moves with steep ramps, the encoder recorded.",
    acts="key",
    key="drive.dead_time_s",
    confused_with={
        "accelerometer_lag": (
            "record the joint's encoder (joint_position_rad) while the joint moves: it shows the "
            "drive without the sensor"
        ),
        "drive_lag": (
            "command steps and fast reversals of the joint's velocity, and record "
            "joint_velocity_rad_s: a dead time shifts the answer, a lag rounds it"
        ),
    },
)
