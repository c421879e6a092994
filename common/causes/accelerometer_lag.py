"""An accelerometer that lags."""

from stillarm.common.causes.declaration import Cause, replacing

CAUSE = Cause(
    "accelerometer_lag",
    "accelerometer",
    name="an accelerometer that lags",
    sees="the acceleration trails the motion by more, or less, than declared",
    note="In a ring-down alone it looks like another mean capture delay.",
    equation="replaces accelerometer.delay_s",
    parameters=(replacing("delay_s", "s", 0.0, 1.0, 0.005, 0.03),),
    provoke="moves, with the encoder recorded.",
    acts="key",
    key="accelerometer.delay_s",
)
