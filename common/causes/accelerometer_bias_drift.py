"""An accelerometer whose zero drifts."""

from stillarm.common.causes.declaration import Cause, size


def law(t: float, tip_angle: float, rate_m_s3: float) -> float:
    """Added to the reading, m/s^2."""
    return rate_m_s3 * t


CAUSE = Cause(
    "accelerometer_bias_drift",
    "accelerometer",
    name="an accelerometer whose zero drifts",
    sees="the accelerometer's zero creeps away",
    equation="a = ... + rate t",
    parameters=(size("rate_m_s3", "m/s^3", 1000.0, 0.005, 0.05, signed=True),),
    provoke="a long recording; rest is enough.",
    acts="reading",
    law=law,
    confused_with={
        "tracking_drift": (
            "revisit the same pose at the beginning, in the middle and at the end: a sag comes back "
            "with the pose, a drift does not"
        ),
    },
)
