"""Gravity in the accelerometer."""

from stillarm.common.causes.declaration import Cause, size


def law(t: float, tip_angle: float, gain_m_s2_per_rad: float) -> float:
    """Added to the reading, m/s^2."""
    return gain_m_s2_per_rad * tip_angle


CAUSE = Cause(
    "gravity_leakage",
    "accelerometer",
    name="gravity in the accelerometer",
    sees="the acceleration at rest depends on the pose: the sensor tilts, and feels gravity",
    equation="a = ... + gain (theta + slope of the tip)",
    parameters=(size("gain_m_s2_per_rad", "m/s^2 a rad", 100.0, 1.0, 9.8, signed=True),),
    provoke="hold two poses far apart for some seconds each.",
    acts="reading",
    law=law,
)
