"""An accelerometer that clips."""

from stillarm.common.causes.declaration import Cause, replacing

CAUSE = Cause(
    "accelerometer_clipping",
    "accelerometer",
    name="an accelerometer that clips",
    sees="the peaks of the acceleration are cut off flat below the declared range",
    equation="replaces accelerometer.range_m_s2",
    parameters=(replacing("range_m_s2", "m/s^2", 1e-06, 1e9, 1.2, 4.0),),
    provoke="the hardest strike, or the fastest move, that is allowed.",
    acts="key",
    key="accelerometer.range_m_s2",
)
