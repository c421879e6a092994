"""An accelerometer whose sensitivity drifts."""

from stillarm.common.causes.declaration import Cause, size


def law(t: float, rate_per_s: float) -> float:
    """Factor on the scale."""
    return 1.0 + rate_per_s * t


CAUSE = Cause(
    "accelerometer_sensitivity_drift",
    "accelerometer",
    name="an accelerometer whose sensitivity drifts",
    sees="the same vibration reads larger, or smaller, as time goes on",
    note="With the accelerometer alone it cannot be told from an excitation that changes.",
    equation="scale (1 + rate t)",
    parameters=(size("rate_per_s", "1/s", 10.0, 0.002, 0.008, signed=True),),
    provoke="strikes of the same size, spread over the whole recording, with images.",
    acts="sensitivity",
    law=law,
)
