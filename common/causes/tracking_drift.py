"""Tracking that drifts."""

from stillarm.common.causes.declaration import Cause, size


def law(d: float, t: float, rate_px_per_s: float) -> float:
    """Added to the displacement d, px."""
    return rate_px_per_s * t


CAUSE = Cause(
    "tracking_drift",
    "camera",
    name="tracking that drifts",
    sees="the image creeps away although the tip returns to its place",
    equation="d = ... + rate t",
    parameters=(size("rate_px_per_s", "px/s", 1000.0, 0.02, 0.3, signed=True),),
    provoke="come back to the same pose after half a minute.",
    acts="image",
    law=law,
)
