"""A lens that distorts."""

from stillarm.common.causes.declaration import Cause, size


def law(d: float, t: float, coefficient_per_px2: float) -> float:
    """Added to the displacement d, px."""
    return coefficient_per_px2 * d * d * d


CAUSE = Cause(
    "lens_distortion",
    "camera",
    name="a lens that distorts",
    sees="far from the image's zero the same motion shows larger (positive coefficient), or smaller",
    equation="d becomes d (1 + coefficient d^2)",
    parameters=(size("coefficient_per_px2", "1/px^2", 1.0, 2e-07, 2e-06, signed=True),),
    provoke="the same strike at both ends of the joint's travel, or one wide move.",
    acts="image",
    law=law,
)
