"""A capture delay that drifts."""

from stillarm.common.causes.declaration import Cause, size


def law(t: float, rate_s_per_s: float) -> float:
    """Delay added, s."""
    return rate_s_per_s * t


CAUSE = Cause(
    "delay_drift",
    "timing",
    name="a capture delay that drifts",
    sees="the capture delay grows, or shrinks, all along",
    note="Bounded below by exposure, read-out and transfer.",
    equation="delay = ... + rate t",
    parameters=(size("rate_s_per_s", "s/s", 0.1, 0.0002, 0.001, signed=True),),
    provoke="the arm ringing at the beginning and at the end of a long recording.",
    acts="delay",
    law=law,
)
