"""A drive of another bandwidth than declared."""

from stillarm.common.causes.declaration import Cause, replacing

CAUSE = Cause(
    "drive_lag",
    "drive",
    name="a drive of another bandwidth than declared",
    sees="the joint's velocity rounds off every corner of its command more, or less, than declared",
    equation="replaces drive.bandwidth_hz",
    parameters=(replacing("bandwidth_hz", "Hz", 0.01, 1e9, 3.0, 10.0),),
    provoke="moves with steep ramps, the encoder recorded.",
    acts="key",
    key="drive.bandwidth_hz",
    confused_with={
        "accelerometer_lag": (
            "record the joint's encoder (joint_position_rad) while the joint moves: it shows the "
            "drive without the sensor"
        ),
    },
)
